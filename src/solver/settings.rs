//! The settings of a solve: one struct for the flags, the state file, the window and the solution's metadata.

use clap::{Args, ValueEnum};
use serde::{Deserialize, Serialize};

use crate::{
    math::sequence::Sampler,
    scene::tessellate::TessellationOptions,
    transport::{lights::DirectMethod, origins::VertexValues},
};

/// Whose functions gather the light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Engine {
    /// The program's own.
    #[cfg_attr(feature = "reference", default)]
    Reference,
    /// Those of src/student.
    #[cfg_attr(not(feature = "reference"), default)]
    Student,
}

/// How the bounces are added up. All lead to the same field.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Iteration {
    /// Bounce by bounce, each kept apart (Neumann's series, Jacobi's iteration).
    #[default]
    Neumann,
    /// By parts of the rows, each seeing what those before it gathered.
    GaussSeidel,
    /// The vertices with most unshot power shoot first (Southwell's rule, progressive refinement).
    Shooting,
    /// The best combination of a few gathers (GMRES): for bright scenes.
    Krylov,
}

/// Everything a solution depends on besides the scene and the light.
#[derive(Clone, Debug, PartialEq, Args, Serialize, Deserialize)]
#[serde(default)]
pub struct SolveSettings {
    /// Whose functions gather the light.
    #[arg(long, value_enum, default_value_t = SolveSettings::default().engine)]
    pub engine: Engine,
    /// Hemisphere rays a vertex. 64 is a preview, 512 good, 2048 fine; powers of two suit the Sobol points. With `--adaptive`
    /// vertices that stand for little surface send fewer.
    #[arg(long, value_name = "N", default_value_t = SolveSettings::default().rays)]
    pub rays: u32,
    /// How direct light is found: by its visible part's closed form, or by samples alone.
    #[arg(long, value_enum, default_value_t = SolveSettings::default().direct)]
    pub direct: DirectMethod,
    /// Shadow rays a vertex where direct light is sampled, for the area light and again for emissive materials.
    #[arg(long, value_name = "N", default_value_t = SolveSettings::default().light_rays)]
    pub light_rays: u32,
    /// Indirect bounces to compute; without it, bounces go on until `--unabsorbed` is reached.
    #[arg(long, value_name = "N")]
    pub bounces: Option<u32>,
    /// Stop when this fraction of the emitted power is still unabsorbed.
    #[arg(long, value_name = "FRACTION", default_value_t = SolveSettings::default().unabsorbed)]
    pub unabsorbed: f32,
    /// How the bounces are added up; others than `neumann` keep direct and indirect light alone, and `--bounces` counts
    /// their sweeps. The engine `student` always goes bounce by bounce.
    #[arg(long, value_enum, default_value_t = SolveSettings::default().iteration)]
    pub iteration: Iteration,
    /// How sample points are placed.
    #[arg(long, value_enum, default_value_t = SolveSettings::default().sampler)]
    pub sampler: Sampler,
    /// Seed of all sample points: the same seed gives the same bits on any number of threads.
    #[arg(long, value_name = "N", default_value_t = SolveSettings::default().seed)]
    pub seed: u64,
    /// Cut every edge in two this many times (2^N segments an edge).
    #[arg(long, value_name = "N", default_value_t = SolveSettings::default().subdivide)]
    pub subdivide: u32,
    /// Bisect edges until none is longer than this, in metres.
    #[arg(long, value_name = "METRES")]
    pub max_edge: Option<f64>,
    /// What a vertex's value stands for, with elements that are cut evenly and the program's own engine: the light at the
    /// point, its mean around the vertex, or what fits the light on the elements best. On the command line it asks for
    /// even elements by itself.
    #[arg(long, value_enum, default_value_t = SolveSettings::default().vertex_values)]
    pub vertex_values: VertexValues,
    /// Cut where the light bends, until the error is about this part of the mean light; 0: cut evenly, by `--subdivide`
    /// and `--max-edge`, which on the command line say so by themselves. The engine `student` has even elements only.
    #[arg(long, value_name = "ERROR", default_value_t = SolveSettings::default().adaptive)]
    pub adaptive: f32,
    /// Cut no finer once there are about this many vertices, with `--adaptive`.
    #[arg(long, value_name = "N", default_value_t = SolveSettings::default().max_vertices)]
    pub max_vertices: u32,
    /// Memory for the traced rows, in MiB; without it, a quarter of the machine's. What does not fit is traced again at
    /// each bounce, with the same result.
    #[arg(long, value_name = "MIB")]
    pub row_memory: Option<u32>,
}

/// What is taken for the machine's memory where it does not tell.
#[cfg(feature = "reference")]
const USUAL_MEMORY: u64 = 8 << 30;

/// Memory of the machine, or of the container that the program runs in, in bytes.
#[cfg(feature = "reference")]
fn machine_memory() -> u64 {
    let Ok(mut system) = sysinfo::System::new() else { return USUAL_MEMORY };
    system.refresh_memory();
    let container = system.cgroup_limits().map_or(u64::MAX, |limits| limits.total_memory);
    match system.total_memory().min(container) {
        0 => USUAL_MEMORY,
        known => known,
    }
}

impl Default for SolveSettings {
    fn default() -> Self {
        Self {
            engine: Engine::default(),
            rays: if cfg!(feature = "reference") { 512 } else { 256 },
            direct: DirectMethod::Analytic,
            light_rays: 64,
            bounces: None,
            // A bounce costs the program's own engine next to nothing.
            unabsorbed: if cfg!(feature = "reference") { 1e-4 } else { 0.01 },
            iteration: Iteration::Neumann,
            sampler: Sampler::Sobol,
            seed: 1,
            subdivide: 0,
            max_edge: None,
            vertex_values: VertexValues::Point,
            adaptive: 0.02,
            max_vertices: 1_000_000,
            row_memory: None,
        }
    }
}

impl SolveSettings {
    /// The defaults, but for elements that are cut evenly.
    pub fn even() -> Self {
        Self { adaptive: 0.0, ..Self::default() }
    }

    /// Memory for the traced rows, in bytes.
    #[cfg(feature = "reference")]
    pub fn row_bytes(&self) -> u64 {
        self.row_memory.map_or_else(|| machine_memory() / 4, |mebibytes| u64::from(mebibytes) << 20)
    }

    /// How the engine that is chosen adds the bounces up.
    pub fn iteration_in_use(&self) -> Iteration {
        if self.engine == Engine::Student { Iteration::Neumann } else { self.iteration }
    }

    /// What vertices' values stand for with the engine and the elements that are chosen.
    pub fn vertex_values_in_use(&self) -> VertexValues {
        let is_even = self.engine == Engine::Reference && !self.follows_light();
        if is_even { self.vertex_values } else { VertexValues::Point }
    }

    /// True if elements are cut where the light bends.
    pub fn follows_light(&self) -> bool {
        self.engine == Engine::Reference && self.adaptive > 0.0
    }

    /// The part that decides the elements; of those that follow the light, the ones to begin with.
    pub fn tessellation(&self) -> TessellationOptions {
        if self.follows_light() {
            return TessellationOptions { subdivide: 0, max_edge: None };
        }
        TessellationOptions { subdivide: self.subdivide, max_edge: self.max_edge }
    }

    /// What is wrong with the settings, if anything.
    pub fn problem(&self) -> Option<String> {
        if self.engine == Engine::Reference && cfg!(not(feature = "reference")) {
            return Some(String::from("this program was built without its own engine; take the engine `student`"));
        }
        if !(self.unabsorbed > 0.0 && self.unabsorbed < 1.0) {
            return Some(format!("unabsorbed must lie between 0 and 1, not be {}", self.unabsorbed));
        }
        if self.max_edge.is_some_and(|length| !(length > 0.0 && length.is_finite())) {
            return Some(String::from("max-edge must be a positive length in metres"));
        }
        if !(0.0..=1.0).contains(&self.adaptive) {
            return Some(format!("adaptive must be an error from 0 to 1, such as 0.02, not {}", self.adaptive));
        }
        if self.subdivide > 12 {
            return Some(format!(
                "subdivide {} would cut every triangle into more than 16 million; at most 12",
                self.subdivide
            ));
        }
        None
    }
}
