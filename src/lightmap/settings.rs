//! The settings of a solve on the graphics card: one struct for the flags, the state file and the window.

use clap::{Args, ValueEnum};
use serde::{Deserialize, Serialize};

/// Who shoots next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ShootingOrder {
    /// The groups of the most unshot power.
    #[default]
    Brightest,
    /// The chart of the highest mean unshot radiosity, with all its groups; then the next.
    Mesh,
}

/// How light fades with distance. Only the first is what light does; the others are what programs have tried.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Attenuation {
    /// The form factor, exact where a shooter is near.
    #[default]
    Physical,
    /// By the distance, whatever a patch's size (too bright from afar; light out of nothing).
    Linear,
    /// By its square, whatever a patch's size.
    Quadratic,
    /// By its square and the patch's size, also where that is near (too bright in corners).
    Patch,
}

/// How a shooter sees.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Visibility {
    /// By the depth on the five faces of a hemicube.
    #[default]
    Hemicube,
    /// By the numbers of the triangles on one hemisphere seen from above (Coombe and Harris 2005). Edges are straight there
    /// that should be bent: light and shadow are misplaced where triangles are large; texels at a triangle's edge stay
    /// dark; cut-outs are whole.
    Hemisphere,
}

/// What is shown and written for the light that has still to be shot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Ambient {
    /// Nothing.
    Off,
    /// As much as it will be in the mean, evenly over the scene (Cohen et al. 1988, ambient term).
    Even,
    /// As much again, on every texel, as came while the unshot power last halved.
    #[default]
    Trend,
}

/// When the window shows what was added.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PageUpdate {
    /// After any submission.
    #[default]
    Continuous,
    /// Once all shooters that were chosen together have shot.
    Batch,
}

/// Everything that a solve on the card depends on besides the scene, the light and the lightmap.
#[derive(Clone, Debug, PartialEq, Args, Serialize, Deserialize)]
#[serde(default)]
pub struct GpuSettings {
    /// Stop when this fraction of the emitted power is still unabsorbed.
    #[arg(long, value_name = "FRACTION", default_value_t = GpuSettings::default().unabsorbed)]
    pub unabsorbed: f32,
    /// Texels along the side of a group that shoots as one, where other surfaces are near: 1, 2, 4, 8 or 16.
    #[arg(long, value_name = "TEXELS", default_value_t = GpuSettings::default().group)]
    pub group: u32,
    /// The same where no other surface is near, or little light is left: 1 to 64, but not less than `group`.
    #[arg(long, value_name = "TEXELS", default_value_t = GpuSettings::default().far_group)]
    pub far_group: u32,
    /// Who shoots next.
    #[arg(long, value_enum, default_value_t = GpuSettings::default().order)]
    pub order: ShootingOrder,
    /// How light fades with distance.
    #[arg(long, value_enum, default_value_t = GpuSettings::default().attenuation)]
    pub attenuation: Attenuation,
    /// How a shooter sees.
    #[arg(long, value_enum, default_value_t = GpuSettings::default().visibility)]
    pub visibility: Visibility,
    /// Pixels along a group's hemicube: even, 16 to 512.
    #[arg(long, value_name = "PIXELS", default_value_t = GpuSettings::default().hemicube)]
    pub hemicube: u32,
    /// Pixels along a light's hemicube: even, 16 to 1024.
    #[arg(long, value_name = "PIXELS", default_value_t = GpuSettings::default().light_hemicube)]
    pub light_hemicube: u32,
    /// The placed area light is cut into this many shooters along each side.
    #[arg(long, value_name = "N", default_value_t = GpuSettings::default().light_side)]
    pub light_side: u32,
    /// How far behind a hemicube's depth a texel may lie and be seen, in pixels.
    #[arg(long, value_name = "PIXELS", default_value_t = GpuSettings::default().bias)]
    pub bias: f32,
    /// The nearest pixel of a hemicube decides what is seen; otherwise the four around, weighted (percentage-closer filtering).
    #[arg(long)]
    pub no_filter: bool,
    /// Shooters that are chosen at once; 0 for one in 32 groups, 32 at most.
    #[arg(long, value_name = "N", default_value_t = GpuSettings::default().batch)]
    pub batch: u32,
    /// What is shown and written for the light that has still to be shot.
    #[arg(long, value_enum, default_value_t = GpuSettings::default().ambient)]
    pub ambient: Ambient,
    /// When the window shows what was added.
    #[arg(long, value_enum, default_value_t = GpuSettings::default().update)]
    pub update: PageUpdate,
    /// Most memory of the device that may be used, in MiB.
    #[arg(long, value_name = "MIB", default_value_t = GpuSettings::default().device_memory)]
    pub device_memory: u32,
}

impl Default for GpuSettings {
    fn default() -> Self {
        Self {
            unabsorbed: 0.01,
            group: 4,
            far_group: 16,
            order: ShootingOrder::Brightest,
            attenuation: Attenuation::Physical,
            visibility: Visibility::Hemicube,
            hemicube: 64,
            light_hemicube: 256,
            light_side: 5,
            bias: 0.5,
            no_filter: false,
            batch: 0,
            ambient: Ambient::Trend,
            update: PageUpdate::Continuous,
            device_memory: 4096,
        }
    }
}

impl GpuSettings {
    /// What is wrong with the settings, if anything.
    pub fn problem(&self) -> Option<String> {
        if !(self.unabsorbed > 0.0 && self.unabsorbed < 1.0) {
            return Some(format!("unabsorbed must lie between 0 and 1, not be {}", self.unabsorbed));
        }
        if !(self.group.is_power_of_two() && self.group <= 16) {
            return Some(format!("group must be 1, 2, 4, 8 or 16 texels, not {}", self.group));
        }
        if !(self.far_group.is_power_of_two() && self.far_group <= 64) {
            return Some(format!("far-group must be 1, 2, 4, ... or 64 texels, not {}", self.far_group));
        }
        for (name, pixels, most) in [("hemicube", self.hemicube, 512), ("light-hemicube", self.light_hemicube, 1024)] {
            if !(16..=most).contains(&pixels) || !pixels.is_multiple_of(2) {
                return Some(format!("{name} must be an even number of pixels from 16 to {most}, not {pixels}"));
            }
        }
        if !(1..=32).contains(&self.light_side) {
            return Some(format!("light-side must lie between 1 and 32, not be {}", self.light_side));
        }
        if !(0.0..=8.0).contains(&self.bias) {
            return Some(format!("bias must lie between 0 and 8 pixels, not be {}", self.bias));
        }
        None
    }
}

/// What a pixel of a hemicube counts in a form factor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PixelWeights {
    /// Its delta form factor (eq. 8).
    #[default]
    Delta,
    /// As much as any other: pixels are counted.
    Plain,
}

/// Who finds form factors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FormFactorMethod {
    /// The graphics card draws each patch's hemicube with the patches' numbers.
    #[cfg_attr(any(feature = "gpu", not(feature = "reference")), default)]
    ItemBuffers,
    /// Rays between the patches of each pair, without a graphics card. Lights shine on the patches' centres by closed
    /// form, so that patches carry indirect light alone.
    #[cfg(feature = "reference")]
    #[cfg_attr(not(feature = "gpu"), default)]
    Rays,
}

/// What two points of a pair of patches tell about all of them.
#[cfg(feature = "reference")]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PairKernel {
    /// Everything: F = A cosθ cosθ' / (π r²), which is too much for patches that touch.
    #[default]
    Point,
    /// Where they are near, what each point sees of the other patch by closed form (eq. 6), in the mean of both ways.
    Polygon,
}

/// How form factors are found, and the radiosity that follows from them.
#[derive(Clone, Debug, PartialEq, Args, Serialize, Deserialize)]
#[serde(default)]
pub struct FormFactorSettings {
    /// Who finds them.
    #[arg(long, value_enum, default_value_t = FormFactorSettings::default().by)]
    pub by: FormFactorMethod,
    /// Cut every edge in two this many times (2^N segments an edge); every triangle is a patch.
    #[arg(long, value_name = "N", default_value_t = FormFactorSettings::default().subdivide)]
    #[arg(default_value_if("max_edge", clap::builder::ArgPredicate::IsPresent, "0"))]
    pub subdivide: u32,
    /// Bisect edges, the longest first, until none is longer than this, in metres; instead of `--subdivide`, or after it.
    #[arg(long, value_name = "METRES")]
    pub max_edge: Option<f64>,
    /// Rays that tell how much of each other two patches see: 1 joins the centres of their incircles, more join points all
    /// over both. With `--by rays`.
    #[cfg(feature = "reference")]
    #[arg(long, value_name = "N", default_value_t = FormFactorSettings::default().pair_rays)]
    pub pair_rays: u32,
    /// What the two points of a ray tell about the patches, with `--by rays`.
    #[cfg(feature = "reference")]
    #[arg(long, value_enum, default_value_t = FormFactorSettings::default().kernel)]
    pub kernel: PairKernel,
    /// Pixels along a hemicube: even, 16 to 512.
    #[arg(long, value_name = "PIXELS", default_value_t = FormFactorSettings::default().resolution)]
    pub resolution: u32,
    /// What a pixel counts.
    #[arg(long, value_enum, default_value_t = FormFactorSettings::default().weights)]
    pub weights: PixelWeights,
    /// Sweeps of Gauss-Seidel; fewer if nothing changes by more than a millionth.
    #[arg(long, value_name = "N", default_value_t = FormFactorSettings::default().sweeps)]
    pub sweeps: u32,
}

impl Default for FormFactorSettings {
    fn default() -> Self {
        Self {
            by: FormFactorMethod::default(),
            subdivide: 3,
            max_edge: None,
            #[cfg(feature = "reference")]
            pair_rays: 1,
            #[cfg(feature = "reference")]
            kernel: PairKernel::Point,
            resolution: 128,
            weights: PixelWeights::Delta,
            sweeps: 50,
        }
    }
}

impl FormFactorSettings {
    /// What is wrong with the settings, if anything.
    pub fn problem(&self) -> Option<String> {
        let pixels = self.resolution;
        if !(16..=512).contains(&pixels) || !pixels.is_multiple_of(2) {
            return Some(format!("the resolution must be an even number of pixels from 16 to 512, not {pixels}"));
        }
        #[cfg(feature = "reference")]
        if !(1..=4096).contains(&self.pair_rays) {
            return Some(format!("pair-rays must lie between 1 and 4096, not be {}", self.pair_rays));
        }
        None
    }

    /// True if sweeps go on after one that changed the radiosity by `change` of its mean.
    pub fn goes_on(&self, sweep: u32, change: f64) -> bool {
        change > 1e-6 && sweep < self.sweeps
    }
}
