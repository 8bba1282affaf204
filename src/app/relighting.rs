//! Changes of the light and of materials, shown at once on the rows of the solve that is shown.

#[cfg(feature = "reference")]
use std::{sync::Arc, time::Duration};

use super::App;
#[cfg(feature = "reference")]
use super::{notices::Level, solving::Solving};

/// What the switch does, for its tooltip and the help.
#[cfg(feature = "reference")]
pub(super) const RELIGHT_LIVE: &str = "After a complete solve, light and materials that are changed light its rays again \
    at once: no ray is traced anew, but those for direct light. The elements stay as they followed the light of the \
    solve; ENTER cuts them anew. Settings, and materials that were black, wait for ENTER; so does everything where the \
    rays did not fit in memory";

impl App {
    /// Lights the kept rows again if the light or a material has changed since, and nothing else is being solved.
    #[cfg(feature = "reference")]
    pub(super) fn relight_if_changed(&mut self) {
        self.supersede_relight();
        let Some(results) = self.results.as_ref().filter(|_| self.layout.relight_live && self.solving.is_none()) else {
            return;
        };
        let Some(kept) = &results.kept else { return };
        let edit = &self.document.edit;
        let is_same = |known: &super::solving::SolveInput| {
            known.light == edit.light && known.materials == edit.materials && known.settings == edit.settings
        };
        if is_same(&results.input) || self.refused.as_ref().is_some_and(is_same) {
            return;
        }
        let input = edit.solve_input();
        let materials_refused = || kept.refuses(&results.elements.with_materials(&input.materials).scene).is_some();
        let is_refused = input.settings != results.input.settings
            || (input.materials != results.input.materials && materials_refused());
        if is_refused {
            self.refused = Some(input);
            return;
        }
        let context = self.context.clone();
        let wake = move || context.request_repaint_after(Duration::from_millis(1));
        match Solving::relight(results.elements.clone(), Arc::clone(kept), input, wake) {
            Ok(solving) => self.solving = Some(solving),
            Err(error) => self.notices.say(Level::Error, format!("no thread for the solver could be started: {error}")),
        }
    }

    /// Ends a relight that was shown in part, if the light or a material has changed since: so a large scene follows the
    /// hand by previews, and is lit exactly once the hand rests.
    #[cfg(feature = "reference")]
    fn supersede_relight(&self) {
        let relight = self.solving.as_ref().filter(|solving| solving.relights && solving.was_shown());
        if let Some(relight) = relight.filter(|relight| relight.input != self.document.edit.solve_input()) {
            relight.cancel();
        }
    }

    /// Without the program's own engine there are no rows.
    #[cfg(not(feature = "reference"))]
    pub(super) fn relight_if_changed(&mut self) {}
}
