//! The settings of the screen-space view: one struct for flags, sliders and what is remembered.

use clap::{Args, ValueEnum};
use serde::{Deserialize, Serialize};

/// What the second layer of the G-buffer is found behind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SecondLayer {
    /// There is none.
    Off,
    /// This frame's first layer (depth peeling).
    #[default]
    Peel,
    /// The last frame's first layer, where it has moved to.
    LastFrame,
}

/// How the light of the taps is weighed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Weights {
    /// By the part of the hemisphere that each tap on a line through the pixel covers before all farther ones: an estimate
    /// of eq. 2 over what the picture shows.
    #[default]
    Integral,
    /// By the cosine alone, over the number of taps of a spiral above the horizon (Nielsen 2015): an estimate of nothing in
    /// particular.
    Source,
}

/// Everything that the screen-space view depends on besides the scene, the light and the camera.
#[derive(Clone, Debug, PartialEq, Args, Serialize, Deserialize)]
#[serde(default)]
pub struct ScreenSettings {
    /// What the second layer is found behind.
    #[arg(long, value_enum, default_value_t = ScreenSettings::default().second_layer)]
    pub second_layer: SecondLayer,
    /// The second layer lies so far behind the first, or farther: a part of the scene's size, 0 to 1.
    #[arg(long, value_name = "PART", default_value_t = ScreenSettings::default().separation)]
    pub separation: f32,
    /// Reflections that are followed: 0 to 8.
    #[arg(long, value_name = "N", default_value_t = ScreenSettings::default().bounces)]
    pub bounces: u32,
    /// Leave out the light of later reflections, which still frames add one after the other if two or more are followed.
    #[arg(long)]
    pub no_tail: bool,
    /// Taps a pixel, layer and bounce: 1 to 128.
    #[arg(long, value_name = "N", default_value_t = ScreenSettings::default().taps)]
    pub taps: u32,
    /// Turns of the source's spiral; 0 for as many as spread that number of taps best.
    #[arg(long, value_name = "N", default_value_t = ScreenSettings::default().turns)]
    pub turns: u32,
    /// How far taps reach: a part of the picture's diagonal, up to 1.
    #[arg(long, value_name = "PART", default_value_t = ScreenSettings::default().radius)]
    pub radius: f32,
    /// Where taps leave the picture they go on in a coarse one around it, so many times as wide and high: 1 to 5; 1 for none.
    #[arg(long, value_name = "TIMES", default_value_t = ScreenSettings::default().surround)]
    pub surround: f32,
    /// Gather bounces at every so many pixels along each side, 1 to 4; the filter fills in what lies between.
    #[arg(long, value_name = "PIXELS", default_value_t = ScreenSettings::default().every)]
    pub every: u32,
    /// How far behind its front a surface hides what is farther: a part of the scene's size, 0 to 1.
    #[arg(long, value_name = "PART", default_value_t = ScreenSettings::default().thickness)]
    pub thickness: f32,
    /// How taps lie, and how their light is weighed.
    #[arg(long, value_enum, default_value_t = ScreenSettings::default().weights)]
    pub weights: Weights,
    /// How much of the light from where taps meet nothing is filled in by the mean of what they meet: 0 to 1. Four times as
    /// much, but no more than all, where something is that is hidden.
    #[arg(long, value_name = "PART", default_value_t = ScreenSettings::default().unseen)]
    pub unseen: f32,
    /// Pieces that the lights are cut into, each with a shadow map of its own: 1 to 64. Over still frames they move about.
    #[arg(long, value_name = "N", default_value_t = ScreenSettings::default().light_samples)]
    pub light_samples: u32,
    /// Pixels along a shadow map: even, 16 to 1024.
    #[arg(long, value_name = "PIXELS", default_value_t = ScreenSettings::default().shadow_map)]
    pub shadow_map: u32,
    /// How far behind a shadow map's depth a surface may lie and be lit, in pixels of the map.
    #[arg(long, value_name = "PIXELS", default_value_t = ScreenSettings::default().shadow_bias)]
    pub shadow_bias: f32,
    /// Radius of the filter in pixels, 0 to 32; 0 for none. Over n still frames it is divided by the fourth root of n.
    #[arg(long, value_name = "PIXELS", default_value_t = ScreenSettings::default().filter)]
    pub filter: u32,
    /// The filter leaves out what lies farther from the pixel's plane: a part of its depth.
    #[arg(long, value_name = "PART", default_value_t = ScreenSettings::default().filter_depth)]
    pub filter_depth: f32,
    /// Taps of the ambient obscurance: 0 to 128; 0 for none.
    #[arg(long, value_name = "N", default_value_t = ScreenSettings::default().obscurance)]
    pub obscurance: u32,
    /// Radius of the ambient obscurance: a part of the scene's size.
    #[arg(long, value_name = "PART", default_value_t = ScreenSettings::default().obscurance_radius)]
    pub obscurance_radius: f32,
    /// Magnitude of the ambient obscurance: 0 to 8.
    #[arg(long, value_name = "N", default_value_t = ScreenSettings::default().obscurance_strength)]
    pub obscurance_strength: f32,
    /// Milliseconds that a frame may take while something moves: resolution, taps and filter give way; 0 for no limit.
    #[arg(long, value_name = "MS", default_value_t = ScreenSettings::default().frame_budget)]
    pub frame_budget: u32,
}

impl Default for ScreenSettings {
    fn default() -> Self {
        Self {
            second_layer: SecondLayer::Peel,
            separation: 0.02,
            bounces: 2,
            no_tail: false,
            taps: 23,
            turns: 0,
            radius: 0.7,
            surround: 3.0,
            every: 2,
            thickness: 0.02,
            weights: Weights::Integral,
            unseen: 0.25,
            light_samples: 4,
            shadow_map: 512,
            shadow_bias: 0.5,
            filter: 12,
            filter_depth: 0.01,
            obscurance: 0,
            obscurance_radius: 0.1,
            obscurance_strength: 1.0,
            frame_budget: 0,
        }
    }
}

/// Taps of a spiral, at most.
pub const MOST_TAPS: u32 = 128;
/// Bounces, at most.
pub const MOST_BOUNCES: u32 = 8;
/// Pieces of the lights, at most.
pub const MOST_LAMPS: u32 = 64;
/// Pixels between those on the grid, at most.
const MOST_EVERY: u32 = 4;
/// Pixels along a side of the picture, for each of the one around it.
const SURROUND_COARSENESS: u32 = 4;
/// Radius of the filter, at most.
const MOST_FILTER: u32 = 32;

impl ScreenSettings {
    /// What is wrong with the settings, if anything.
    pub fn problem(&self) -> Option<String> {
        let counts = [
            ("bounces", self.bounces, 0, MOST_BOUNCES),
            ("taps", self.taps, 1, MOST_TAPS),
            ("turns", self.turns, 0, 1000),
            ("every", self.every, 1, MOST_EVERY),
            ("light-samples", self.light_samples, 1, MOST_LAMPS),
            ("shadow-map", self.shadow_map, 16, 1024),
            ("filter", self.filter, 0, MOST_FILTER),
            ("obscurance", self.obscurance, 0, MOST_TAPS),
        ];
        for (name, value, least, most) in counts {
            if !(least..=most).contains(&value) {
                return Some(format!("{name} must lie between {least} and {most}, not be {value}"));
            }
        }
        if !self.shadow_map.is_multiple_of(2) {
            return Some(format!("shadow-map must be an even number of pixels, not {}", self.shadow_map));
        }
        let parts = [
            ("separation", self.separation, 0.0, 1.0),
            ("radius", self.radius, 0.001, 1.0),
            ("surround", self.surround, 1.0, 5.0),
            ("thickness", self.thickness, 0.0, 1.0),
            ("unseen", self.unseen, 0.0, 1.0),
            ("shadow-bias", self.shadow_bias, 0.0, 8.0),
            ("filter-depth", self.filter_depth, 1e-4, 1.0),
            ("obscurance-radius", self.obscurance_radius, 1e-4, 1.0),
            ("obscurance-strength", self.obscurance_strength, 0.0, 8.0),
        ];
        let bad = parts.into_iter().find(|(_, value, least, most)| !(*least..=*most).contains(value));
        bad.map(|(name, value, least, most)| format!("{name} must lie between {least} and {most}, not be {value}"))
    }

    /// Layers of the G-buffer.
    pub fn layers(&self) -> u32 {
        if self.second_layer == SecondLayer::Off { 1 } else { 2 }
    }

    /// Radius of the filter after so many still frames: it shrinks, as noise does, but slower, since blur grows by the square
    /// of it; and it goes on to mix the pixels of the grid that share out their directions.
    pub fn filter_radius(&self, still: u32) -> u32 {
        let shrunk = (self.filter as f32 / ((still + 1) as f32).powf(0.25)) as u32;
        let to_next = if self.every > 1 { self.every } else { 0 };
        shrunk.max(self.filter.min(3 * self.every)).max(to_next)
    }

    /// Columns and rows of the grid.
    pub fn grid(&self, size: [u32; 2]) -> [u32; 2] {
        size.map(|pixels| pixels.div_ceil(self.every))
    }

    /// Columns and rows of the picture around a picture of this size; 0 if there is none. The source's taps end with the
    /// picture.
    pub fn surround_size(&self, size: [u32; 2]) -> [u32; 2] {
        if self.surround > 1.0 && self.weights == Weights::Integral && self.bounces > 0 {
            size.map(|pixels| pixels.div_ceil(SURROUND_COARSENESS))
        } else {
            [0; 2]
        }
    }

    /// Turns of the spiral.
    pub fn spiral_turns(&self) -> u32 {
        if self.turns > 0 {
            return self.turns;
        }
        TURNS.get(self.taps as usize - 1).copied().unwrap_or(TURNS[TURNS.len() - 1]).into()
    }
}

/// Turns that spread n + 1 taps best (Mara et al. 2014).
const TURNS: [u8; 97] = [
    1, 1, 2, 3, 2, 5, 2, 3, 2, 3, 3, 5, 5, 3, 4, 7, 5, 5, 7, 9, 8, 5, 5, 7, 7, 8, 5, 8, 11, 12, 7, 10, 13, 8, 11, 8, 7,
    14, 11, 11, 13, 12, 13, 19, 17, 13, 11, 18, 19, 11, 11, 14, 17, 21, 15, 16, 17, 18, 13, 17, 11, 17, 19, 18, 25, 18,
    19, 19, 29, 21, 19, 27, 31, 29, 21, 18, 17, 29, 31, 31, 23, 18, 25, 26, 25, 23, 19, 34, 19, 27, 21, 25, 39, 29, 17,
    21, 27,
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_setting_out_of_range_is_told_with_its_name_and_nan_is_out_of_range() {
        assert_eq!(ScreenSettings::default().problem(), None);
        let bad = ScreenSettings { taps: 0, ..ScreenSettings::default() };
        assert!(bad.problem().is_some_and(|problem| problem.contains("taps")));
        let bad = ScreenSettings { radius: f32::NAN, ..ScreenSettings::default() };
        assert!(bad.problem().is_some_and(|problem| problem.contains("radius")));
        let bad = ScreenSettings { shadow_map: 17, ..ScreenSettings::default() };
        assert!(bad.problem().is_some_and(|problem| problem.contains("shadow-map")));
    }
}
