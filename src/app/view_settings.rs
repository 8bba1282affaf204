//! What a view shows.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::results::{Field, Results};
use crate::{
    gpu::{FalseColorRange, Shading},
    math::color::luminance,
};

/// The quantity that a view shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Shown {
    /// Radiance that leaves the surfaces.
    Radiosity,
    /// Irradiance, all bounces.
    Irradiance,
    /// Irradiance of bounce 0.
    Direct,
    /// Irradiance of the bounces from 1 on.
    Indirect,
    /// Irradiance of one bounce alone.
    Bounce,
    /// Radiosity of the bounces up to one.
    UpToBounce,
    /// Reflectance.
    Albedo,
    /// Shading normals.
    Normals,
    /// Standard error by sampling.
    SamplingError,
    /// Error against a truth.
    TruthError,
}

impl Shown {
    /// All of them, in the order of the key V.
    pub const ALL: [Self; 10] = [
        Self::Radiosity,
        Self::Irradiance,
        Self::Direct,
        Self::Indirect,
        Self::Bounce,
        Self::UpToBounce,
        Self::Albedo,
        Self::Normals,
        Self::SamplingError,
        Self::TruthError,
    ];

    /// Its name in the panel.
    pub fn name(self) -> &'static str {
        match self {
            Self::Radiosity => "radiosity",
            Self::Irradiance => "irradiance",
            Self::Direct => "direct",
            Self::Indirect => "indirect",
            Self::Bounce => "bounce",
            Self::UpToBounce => "up to",
            Self::Albedo => "albedo",
            Self::Normals => "normals",
            Self::SamplingError => "sampling error",
            Self::TruthError => "truth error",
        }
    }

    /// What it is, for the tooltip.
    pub fn explanation(self) -> &'static str {
        match self {
            Self::Radiosity => "Light that leaves the surfaces: emission plus reflectance times irradiance",
            Self::Irradiance => "Light that arrives, as if all surfaces were white",
            Self::Direct => "Light that arrives straight from the lights (bounce 0)",
            Self::Indirect => "Light that arrives after one reflection or more",
            Self::Bounce => "Light that arrives after that many reflections",
            Self::UpToBounce => "Radiosity if light stopped after that many reflections",
            Self::Albedo => "Reflectance of the surfaces, without light",
            Self::Normals => "Direction of the surface as a colour",
            Self::SamplingError => {
                "Standard error of the irradiance by its samples, from the scatter of four blocks of them; \
                 once the solve is done. For Sobol and stratified points it is rather too large"
            }
            Self::TruthError => "How far the irradiance is from the truth at the points around (panel Solution)",
        }
    }

    /// The next one.
    pub fn next(self) -> Self {
        let place = Self::ALL.iter().position(|known| *known == self).unwrap_or(0);
        Self::ALL[(place + 1) % Self::ALL.len()]
    }

    /// True if it is told by the number of a bounce.
    pub fn has_bounce(self) -> bool {
        matches!(self, Self::Bounce | Self::UpToBounce)
    }

    /// True if it is shown in false colours only.
    pub fn is_error(self) -> bool {
        matches!(self, Self::SamplingError | Self::TruthError)
    }

    /// True if it has no light in it.
    pub fn is_unlit(self) -> bool {
        matches!(self, Self::Albedo | Self::Normals)
    }
}

/// Which solution a view shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Source {
    /// The present one.
    Present,
    /// The one that was kept or read for comparison.
    Other,
    /// How far they are apart at each vertex.
    Difference,
    /// The lightmap, texel by texel.
    Lightmap,
    /// How far the lightmap is from the present one, pixel by pixel.
    LightmapDifference,
    /// The scene in screen space.
    Screen,
    /// How far that is from the present one, pixel by pixel.
    ScreenDifference,
}

impl Source {
    /// True if the lightmap's pages are read.
    pub fn is_lightmap(self) -> bool {
        matches!(self, Self::Lightmap | Self::LightmapDifference)
    }

    /// True if it is drawn in screen space.
    pub fn is_screen(self) -> bool {
        matches!(self, Self::Screen | Self::ScreenDifference)
    }

    /// True if it is a difference.
    fn is_difference(self) -> bool {
        matches!(self, Self::Difference | Self::LightmapDifference | Self::ScreenDifference)
    }
}

/// The settings of one view.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ViewSettings {
    /// What is shown.
    pub shown: Shown,
    /// The bounce, where one is asked for.
    pub bounce: usize,
    /// Which solution.
    pub source: Source,
    /// Edges of the elements over it.
    pub wireframe: bool,
    /// False colours.
    pub false_colour: bool,
    /// The false colours' range is logarithmic.
    pub logarithmic: bool,
    /// Upper end of the false colours, in W/m²; by the field's own values if none.
    pub maximum: Option<f32>,
    /// Hatches the elements around buried vertices.
    pub buried: bool,
}

impl Default for ViewSettings {
    fn default() -> Self {
        Self {
            shown: Shown::Radiosity,
            bounce: 1,
            source: Source::Present,
            wireframe: false,
            false_colour: false,
            logarithmic: false,
            maximum: None,
            buried: false,
        }
    }
}

/// The part of a field that differences to the lightmap are expected to stay below.
const DIFFERENCE_PART: f32 = 0.1;

/// A field for a view, with what it was made of, so that it is made again only if that changed.
#[derive(Clone)]
pub struct ViewField {
    /// The field, in W/m².
    pub field: Field,
    /// Counts the fields that this view has shown.
    pub version: u64,
    /// The value that most of the field stays below (in W/m²), for the false colours.
    pub bright: f32,
    made_of: Option<MadeOf>,
}

#[derive(Clone)]
struct MadeOf {
    settings: (Shown, usize, Source),
    present: (Field, usize),
    other: Option<Field>,
}

impl Default for ViewField {
    fn default() -> Self {
        Self { field: Arc::default(), version: 0, bright: 1.0, made_of: None }
    }
}

impl ViewField {
    /// Makes the field that the settings ask for, unless it is there already.
    pub fn update(&mut self, settings: &ViewSettings, present: &Results, other: Option<&Results>) {
        let made_of = MadeOf {
            settings: (settings.shown, settings.bounce, settings.source),
            present: (field_behind(settings, present), present.bounces.len()),
            other: other.map(|other| Arc::clone(&other.total)),
        };
        if self.made_of.as_ref().is_some_and(|before| before.is_same(&made_of)) {
            return;
        }
        self.field = match (settings.source, other) {
            (Source::Other, Some(other)) => field_of(settings, other),
            (Source::Difference, Some(other)) => {
                let there = present.elements.resampled(&field_of(settings, other), &other.elements);
                difference(&field_of(settings, present), &there)
            }
            _ => field_of(settings, present),
        };
        self.bright = bright_value(&self.field);
        if settings.source.is_difference() && settings.source != Source::Difference {
            self.bright *= DIFFERENCE_PART;
        }
        self.version += 1;
        self.made_of = Some(made_of);
    }

    /// Forgets the field, for a scene without a solution.
    pub fn clear(&mut self) {
        if self.made_of.take().is_some() {
            *self = Self { version: self.version + 1, ..Self::default() };
        }
    }
}

impl MadeOf {
    fn is_same(&self, other: &Self) -> bool {
        let same_other = match (&self.other, &other.other) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            (None, None) => true,
            _ => false,
        };
        self.settings == other.settings
            && same_other
            && self.present.1 == other.present.1
            && Arc::ptr_eq(&self.present.0, &other.present.0)
    }
}

/// The field that changes when what is shown has to.
fn field_behind(settings: &ViewSettings, results: &Results) -> Field {
    let behind = match settings.shown {
        Shown::SamplingError => results.sampling_error.as_ref(),
        Shown::TruthError => results.truth.as_ref().map(|truth| &truth.field),
        _ => None,
    };
    Arc::clone(behind.unwrap_or(&results.total))
}

fn field_of(settings: &ViewSettings, results: &Results) -> Field {
    match settings.shown {
        Shown::Radiosity | Shown::Irradiance | Shown::Albedo | Shown::Normals => Arc::clone(&results.total),
        Shown::SamplingError => results.sampling_error.clone().unwrap_or_else(|| results.sum(1, 0)),
        Shown::TruthError => results.truth.as_ref().map_or_else(|| results.sum(1, 0), |truth| Arc::clone(&truth.field)),
        // Until bounce 0 is complete, the live field is direct light and nothing else.
        Shown::Direct => results.bounces.first().map_or_else(|| Arc::clone(&results.total), Arc::clone),
        Shown::Indirect => results.sum(1, usize::MAX),
        Shown::Bounce => results.bounces.get(settings.bounce).map_or_else(|| results.sum(1, 0), Arc::clone),
        Shown::UpToBounce => results.sum(0, settings.bounce),
    }
}

/// The absolute difference at each vertex.
fn difference(present: &Field, other: &Field) -> Field {
    Arc::new(present.iter().zip(other.iter()).map(|(a, b)| (*a - *b).abs()).collect())
}

/// The luminance that all but 2 % of the vertices stay below, from at most some thousand of them; at least 1e-6.
fn bright_value(field: &Field) -> f32 {
    let step = (field.len() / 4096).max(1);
    let mut values: Vec<f32> = field.iter().step_by(step).map(|value| luminance(*value)).collect();
    values.sort_unstable_by(f32::total_cmp);
    values.get(values.len() * 98 / 100).copied().unwrap_or(1.0).max(1e-6)
}

impl ViewSettings {
    /// How the surfaces are shaded, with the false colours' range by a field's bright value.
    pub fn shading(&self, bright: f32) -> Shading {
        if self.has_legend() {
            return Shading::FalseColor(self.range(bright));
        }
        match self.shown {
            Shown::Radiosity | Shown::UpToBounce => Shading::Radiosity,
            Shown::Irradiance | Shown::Direct | Shown::Indirect | Shown::Bounce => Shading::Irradiance,
            Shown::SamplingError | Shown::TruthError => Shading::Irradiance,
            Shown::Albedo => Shading::Albedo,
            Shown::Normals => Shading::Normals,
        }
    }

    /// True if false colours are shown.
    pub fn has_legend(&self) -> bool {
        let asked = self.false_colour || self.source.is_difference() || self.shown.is_error();
        asked && !self.shown.is_unlit()
    }

    /// The false colours' range; a logarithmic one spans three decades.
    pub fn range(&self, bright: f32) -> FalseColorRange {
        let maximum = self.maximum.unwrap_or(bright).max(1e-9);
        let minimum = if self.logarithmic { 1e-3 * maximum } else { 0.0 };
        FalseColorRange { minimum, maximum, logarithmic: self.logarithmic }
    }

    /// What the view shows, in words.
    pub fn title(&self) -> String {
        let mut title = String::from(self.shown.name());
        if self.shown.has_bounce() {
            let name = if self.shown == Shown::Bounce { "bounce" } else { "up to bounce" };
            title = format!("{name} {}", self.bounce);
        }
        match self.source {
            Source::Present => title,
            Source::Other => format!("{title}, other solution"),
            Source::Difference => format!("{title}, difference [W/m²]"),
            Source::Lightmap => format!("{title}, lightmap"),
            Source::LightmapDifference => format!("{title}, difference to the lightmap [W/m²]"),
            Source::Screen => format!("{title}, screen space"),
            Source::ScreenDifference => format!("{title}, difference to screen space [W/m²]"),
        }
    }
}
