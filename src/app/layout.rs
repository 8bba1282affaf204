//! What the window remembers from one run to the next, besides what egui remembers of its own panels.

use serde::{Deserialize, Serialize};

use super::view_settings::{Shown, ViewSettings};

/// Which panels are open, and what the views show.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Layout {
    /// The panels on the left.
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
}

impl Default for Layout {
    fn default() -> Self {
        let second = ViewSettings { shown: Shown::Indirect, ..ViewSettings::default() };
        Self {
            panels: true,
            plots: true,
            help: false,
            frame_times: false,
            second_view: false,
            divider: 0.5,
            ambient: true,
            antialias: true,
            views: [ViewSettings::default(), second],
        }
    }
}
