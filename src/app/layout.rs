//! What the window remembers from one run to the next.

use serde::{Deserialize, Serialize};

use super::{
    panes::{self, Pane},
    view_settings::{Shown, Source, ViewSettings},
};
use crate::gpu::screen_space::ScreenSettings;

/// Milliseconds that a screen-space frame may take at first, while something moves.
const FRAME_BUDGET: u32 = 100;

/// Which panels are open, and what the views show.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Layout {
    /// Where everything stands.
    pub tree: egui_tiles::Tree<Pane>,
    /// Panels that the menu hides.
    pub hidden: Vec<Pane>,
    /// The panel whose tab is to be opened in the next frame.
    #[serde(skip)]
    pub to_front: Option<Pane>,
    /// The panels, all that are not hidden.
    pub panels: bool,
    /// The plots.
    pub plots: bool,
    /// The help.
    #[serde(skip)]
    pub help: bool,
    /// The table of frame times.
    pub frame_times: bool,
    /// The second view beside the first.
    pub second_view: bool,
    /// The part of the width that the first view has.
    pub divider: f32,
    /// Ambient light for looking round; not remembered: a scene without a solution starts with it.
    #[serde(skip)]
    pub ambient: bool,
    /// Four samples a pixel.
    pub antialias: bool,
    /// The first and the second view.
    pub views: [ViewSettings; 2],
    /// Changes of light and materials light the rows of a complete solve again at once.
    pub relight_live: bool,
    /// How the screen-space view is drawn.
    pub screen: ScreenSettings,
}

impl Default for Layout {
    fn default() -> Self {
        let second = ViewSettings { shown: Shown::Indirect, ..ViewSettings::default() };
        Self {
            tree: panes::first_tree(),
            hidden: Vec::new(),
            to_front: None,
            panels: true,
            plots: true,
            help: false,
            frame_times: false,
            relight_live: true,
            second_view: false,
            divider: 0.5,
            ambient: true,
            antialias: true,
            views: [ViewSettings::default(), second],
            screen: ScreenSettings { frame_budget: FRAME_BUDGET, ..ScreenSettings::default() },
        }
    }
}

impl Layout {
    /// This layout as a window can begin with it: if parts are missing in it, in the first arrangement; and with views of
    /// what is there at the start, which no lightmap and no second solution is.
    pub fn checked(mut self) -> Self {
        for view in self.views.iter_mut().filter(|view| !view.source.is_screen()) {
            view.source = Source::Present;
        }
        if panes::is_complete(&self.tree) { self } else { Self { tree: panes::first_tree(), ..self } }
    }

    /// True if a part of the window is to be seen.
    pub fn shows(&self, pane: Pane) -> bool {
        match pane {
            Pane::Views => true,
            Pane::Plots => self.plots,
            panel => self.panels && !self.hidden.contains(&panel),
        }
    }

    /// Everything where it stood at first.
    pub fn reset_panes(&mut self) {
        (self.tree, self.hidden, self.panels, self.plots) = (panes::first_tree(), Vec::new(), true, true);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_window_does_not_begin_with_a_view_of_a_lightmap_or_solution_that_is_not_there() {
        for (source, begun) in [
            (Source::Lightmap, Source::Present),
            (Source::LightmapDifference, Source::Present),
            (Source::Other, Source::Present),
            (Source::Difference, Source::Present),
            (Source::Screen, Source::Screen),
        ] {
            let mut layout = Layout::default();
            layout.views[1].source = source;
            assert_eq!(layout.checked().views[1].source, begun);
        }
    }
}
