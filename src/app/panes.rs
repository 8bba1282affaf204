//! The parts of the window, which can be dragged elsewhere, put into one another as tabs, sized and hidden.

use egui::{Color32, Ui, WidgetText};
use egui_tiles::{
    Behavior, Container, Linear, LinearDir, SimplificationOptions, Tabs, Tile, TileId, Tiles, Tree, UiResponse,
};
use serde::{Deserialize, Serialize};

use super::{App, command::Command, file_dialog::Purpose, panel_assignment, panel_light, panel_scene, panel_solution};
use super::{panel_solve, panel_view, plots};

/// A part of the window.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Pane {
    /// The pictures of the scene.
    Views,
    /// Curves of convergence.
    Plots,
    /// The solver's settings.
    Solver,
    /// Tests of the student's functions.
    Assignment,
    /// The lightmap of the graphics card.
    Lightmap,
    /// The scene in screen space.
    Screen,
    /// What the views show, and the tone map.
    View,
    /// The area light.
    Light,
    /// Counts, repairs and materials.
    Scene,
    /// Saving, loading, comparing.
    Solution,
    /// What is known of the clicked point.
    Point,
    /// Warnings and errors.
    Log,
}

/// In less width than this, in points, plots are left out.
const LEAST_PLOTS: f32 = 160.0;
/// The panels that stand above and below one another at first, as tabs.
const FIRST_GROUPS: [&[Pane]; 2] = [
    &[Pane::Solver, Pane::Assignment, Pane::Lightmap, Pane::Screen],
    &[Pane::View, Pane::Light, Pane::Scene, Pane::Solution, Pane::Point, Pane::Log],
];

impl Pane {
    /// All panels, in the order of the menu that shows and hides them.
    pub fn panels() -> impl Iterator<Item = Self> {
        FIRST_GROUPS.into_iter().flatten().copied()
    }

    /// What its tab says.
    pub fn title(self) -> String {
        format!("{self:?}")
    }

    fn is_panel(self) -> bool {
        !matches!(self, Self::Views | Self::Plots)
    }
}

/// How the window is laid out at first: panels on the left, views above plots on the right.
pub fn first_tree() -> Tree<Pane> {
    let mut tiles = Tiles::default();
    let groups = FIRST_GROUPS.map(|group| {
        let panes = group.iter().map(|pane| tiles.insert_pane(*pane)).collect();
        tiles.insert_tab_tile(panes)
    });
    let split = |tiles: &mut Tiles<Pane>, direction, parts, share| {
        tiles.insert_container(Container::Linear(Linear::new_binary(direction, parts, share)))
    };
    let panels = split(&mut tiles, LinearDir::Vertical, groups, 0.55);
    let pictures = [Pane::Views, Pane::Plots].map(|pane| tiles.insert_pane(pane));
    let pictures = split(&mut tiles, LinearDir::Vertical, pictures, 0.78);
    let root = split(&mut tiles, LinearDir::Horizontal, [panels, pictures], 0.26);
    Tree::new(egui::Id::unique("panes"), root, tiles)
}

/// True if a remembered tree holds every part of the window once.
pub fn is_complete(tree: &Tree<Pane>) -> bool {
    let held = |wanted: Pane| tree.tiles.tiles().filter(|tile| **tile == Tile::Pane(wanted)).count() == 1;
    Pane::panels().chain([Pane::Views, Pane::Plots]).all(held)
}

/// Draws the parts, and tells what they ask for.
pub(super) fn ui(app: &mut App, ui: &mut Ui) -> Vec<Command> {
    // The tree is lent out apart, as its parts are drawn from the rest.
    let mut tree = std::mem::replace(&mut app.layout.tree, Tree::empty(egui::Id::unique("panes")));
    let panes: Vec<(TileId, Pane)> = tree.tiles.iter().filter_map(|(id, tile)| Some((*id, *pane_of(tile)?))).collect();
    for (id, pane) in &panes {
        tree.set_visible(*id, app.layout.shows(*pane));
    }
    if let Some(wanted) = app.layout.to_front.take() {
        tree.make_active(|_, tile| *tile == Tile::Pane(wanted));
    }
    let pictures = panes.iter().filter(|(_, pane)| !pane.is_panel()).map(|(id, _)| *id).collect();
    let mut contents = Contents { app, commands: Vec::new(), pictures };
    tree.ui(&mut contents, ui);
    let commands = contents.commands;
    app.layout.tree = tree;
    commands
}

fn pane_of(tile: &Tile<Pane>) -> Option<&Pane> {
    match tile {
        Tile::Pane(pane) => Some(pane),
        Tile::Container(_) => None,
    }
}

/// What the parts show.
struct Contents<'a> {
    app: &'a mut App,
    commands: Vec<Command>,
    /// Views and plots, which have no title while they stand alone.
    pictures: Vec<TileId>,
}

impl Behavior<Pane> for Contents<'_> {
    fn pane_ui(&mut self, ui: &mut Ui, _tile: TileId, pane: &mut Pane) -> UiResponse {
        match pane {
            Pane::Views => {
                self.app.frame_times.end_stage(1);
                self.app.view_area = ui.available_rect_before_wrap();
                self.app.view_ui(ui);
                self.app.frame_times.end_stage(2);
            }
            Pane::Plots => {
                self.app.plots_area = ui.available_rect_before_wrap();
                let saves = egui::Frame::NONE
                    .inner_margin(6)
                    .show(ui, |ui| ui.available_width() > LEAST_PLOTS && plots::ui(ui, self.app.results.as_ref()));
                self.commands.extend(saves.inner.then_some(Command::Ask(Purpose::SavePlots)));
            }
            panel => {
                let frame = egui::Frame::NONE.inner_margin(egui::Margin { left: 8, right: 2, top: 6, bottom: 2 });
                frame.show(ui, |ui| {
                    let scroll = egui::ScrollArea::vertical().id_salt(*panel as u8).auto_shrink([false, false]);
                    self.commands.extend(scroll.show(ui, |ui| panel_ui(self.app, ui, *panel)).inner);
                });
            }
        }
        UiResponse::None
    }

    fn tab_title_for_pane(&mut self, pane: &Pane) -> WidgetText {
        pane.title().into()
    }

    /// A panel that stands alone keeps its tab, to be dragged by.
    fn simplification_options(&self) -> SimplificationOptions {
        SimplificationOptions { all_panes_must_have_tabs: true, ..SimplificationOptions::default() }
    }

    fn is_tab_bar_visible(&self, _tile: TileId, tabs: &Tabs) -> bool {
        !matches!(tabs.children[..], [alone] if self.pictures.contains(&alone))
    }

    fn min_size(&self) -> f32 {
        60.0
    }

    fn tab_title_spacing(&self, _visuals: &egui::Visuals) -> f32 {
        6.0
    }

    /// Grounds are left to the clearing of the window, see `theme`.
    fn tab_bar_color(&self, _visuals: &egui::Visuals) -> Color32 {
        Color32::TRANSPARENT
    }
}

/// What a panel shows, and what it asks for.
fn panel_ui(app: &mut App, ui: &mut Ui, panel: Pane) -> Option<Command> {
    let App { document, layout, results, other, notices, picked, assignment, shares, lightmap, screen, .. } = app;
    match panel {
        Pane::Solver => panel_solve::ui(ui, &mut document.edit.settings),
        Pane::Assignment => {
            return panel_assignment::ui(ui, assignment, &mut document.edit.settings.engine, picked.is_some());
        }
        Pane::Lightmap => return lightmap.ui(ui, &document.edit.tone_map, results.as_ref(), other.as_ref()),
        Pane::Screen => screen.ui(ui, &mut layout.screen),
        Pane::View => {
            let bounces = results.as_ref().map_or(0, |results| results.bounces.len());
            let available =
                panel_view::Available { bounces, other: other.is_some(), lightmap: lightmap.shown.is_some() };
            return panel_view::ui(ui, layout, &mut document.edit.tone_map, available);
        }
        Pane::Light => return panel_light::ui(ui, document),
        Pane::Scene => return panel_scene::ui(ui, document),
        Pane::Solution => return panel_solution::ui(ui, results.as_ref(), other.as_ref()),
        Pane::Log => panel_solution::log_ui(ui, notices),
        Pane::Point => {
            let elements = results.as_ref().map_or(&document.elements, |results| &results.elements).clone();
            let shares = shares.find(*picked, results.as_ref());
            if picked.is_none() {
                ui.label("Click a surface: what is known of the point is told here.");
            }
            *picked = picked.filter(|picked| picked.ui(ui, &elements, results.as_ref(), &shares));
        }
        Pane::Views | Pane::Plots => {}
    }
    None
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]
mod tests {
    use super::*;

    #[test]
    fn the_first_layout_is_complete_and_is_remembered_as_it_is() {
        let tree = first_tree();
        assert!(is_complete(&tree));
        let text = serde_json::to_string(&tree).unwrap();
        assert!(serde_json::from_str::<Tree<Pane>>(&text).unwrap() == tree);
    }

    #[test]
    fn a_layout_that_lacks_a_part_or_holds_one_twice_is_not_complete() {
        let mut lacks = first_tree();
        let log = lacks.tiles.find_pane(&Pane::Log).unwrap();
        lacks.remove_recursively(log);
        assert!(!is_complete(&lacks));
        let mut twice = first_tree();
        let _ = twice.tiles.insert_pane(Pane::Log);
        assert!(!is_complete(&twice));
    }
}
