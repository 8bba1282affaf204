//! Scenes as text, before they are read, so that a case of the stress test can put anything into them.

use std::fmt::Write as _;

use glam::DVec3;
use rand::{RngExt, SeedableRng, rngs::SmallRng};

use crate::{
    scene::{area_light::AreaLightState, builtin},
    solver::State,
};

/// A scene's files, and its light.
#[derive(Clone, Debug)]
pub(super) struct Draft {
    pub(super) obj: String,
    pub(super) mtl: String,
    pub(super) light: Option<AreaLightState>,
}

impl Draft {
    /// The Cornell box with its light.
    pub(super) fn cornell() -> Self {
        let light = State::from_toml(builtin::CORNELL_STATE).ok().and_then(|(state, _)| state.light);
        Self { obj: builtin::CORNELL_OBJ.into(), mtl: builtin::CORNELL_MTL.into(), light }
    }

    /// A closed cube, seen from inside, whose walls emit radiance 1 and reflect this much.
    pub(super) fn furnace(reflectance: f64) -> Self {
        let obj = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nusemtl wall\n\
                   f 1 2 3 4\nf 8 7 6 5\nf 5 6 2 1\nf 6 7 3 2\nf 7 8 4 3\nf 8 5 1 4\n";
        let mtl = format!("newmtl wall\nKd {reflectance} {reflectance} {reflectance}\nKe 1 1 1\n");
        Self { obj: obj.into(), mtl, light: None }
    }

    /// A single triangle under the light of [`Draft::cornell`].
    pub(super) fn triangle() -> Self {
        let obj = "v 0.1 0 0.1\nv 0.2 0 0.5\nv 0.5 0 0.2\nusemtl white\nf 1 2 3\n".into();
        Self { obj, ..Self::cornell() }
    }

    /// Triangles anywhere in a cube, of any size and shape; with `on_grid`, corners that meet, so that many triangles
    /// coincide, intersect along edges and are degenerate. Some emit, and a light hangs among them.
    pub(super) fn soup(seed: u64, triangles: u32, on_grid: bool) -> Self {
        let mut random = SmallRng::seed_from_u64(seed);
        let (mut obj, mut mtl) = (String::new(), String::new());
        for material in 0..4 {
            let [red, green, blue] = [0; 3].map(|_| random.random_range(0.0..0.9));
            let emitted = if material == 0 { random.random_range(0.0..5.0) } else { 0.0 };
            let _ = writeln!(mtl, "newmtl m{material}\nKd {red} {green} {blue}\nKe {emitted} {emitted} 0");
        }
        for triangle in 0..triangles {
            let centre: [f64; 3] = std::array::from_fn(|_| random.random_range(0.0..1.0));
            let size = 10_f64.powf(random.random_range(-4.0..0.0));
            for _ in 0..3 {
                let place = centre.map(|value| value + size * random.random_range(-1.0..1.0));
                let [x, y, z] = if on_grid { place.map(|value| (3.0 * value).round() / 3.0) } else { place };
                let _ = writeln!(obj, "v {x} {y} {z}");
            }
            // A few emitters only: light from more of them has to be sampled.
            let material = if triangle < 8 { 0 } else { random.random_range(1..4) };
            let first = 3 * triangle + 1;
            let _ = writeln!(obj, "usemtl m{material}\nf {first} {} {}", first + 1, first + 2);
        }
        let light = AreaLightState { centre: [0.5; 3], u: [0.1, 0.02, 0.0], v: [0.0, 0.03, 0.1], radiance: [3.0; 3] };
        Self { obj, mtl, light: Some(light) }
    }

    /// With all places mapped by an affine function, the light too.
    fn mapped(self, map: impl Fn(DVec3) -> DVec3) -> Self {
        let line = |line: &str| match line.strip_prefix("v ") {
            None => String::from(line),
            Some(words) => {
                let numbers: Vec<f64> = words.split_whitespace().filter_map(|word| word.parse().ok()).collect();
                let [x, y, z] = map(DVec3::from_slice(&numbers)).to_array();
                format!("v {x} {y} {z}")
            }
        };
        let lines: Vec<String> = self.obj.lines().map(line).collect();
        let direction = |vector: [f64; 3]| (map(vector.into()) - map(DVec3::ZERO)).to_array();
        let light = self.light.map(|light| AreaLightState {
            centre: map(light.centre.into()).to_array(),
            u: direction(light.u),
            v: direction(light.v),
            ..light
        });
        Self { obj: lines.join("\n") + "\n", light, ..self }
    }

    /// So many times as large.
    pub(super) fn scaled(self, factor: f64) -> Self {
        self.mapped(|place| factor * place)
    }

    /// Moved by this many metres.
    pub(super) fn moved(self, offset: DVec3) -> Self {
        self.mapped(|place| place + offset)
    }

    /// With more lines at the end of the OBJ file.
    pub(super) fn with(mut self, lines: &str) -> Self {
        self.obj.push_str(lines);
        self
    }

    /// The Cornell box with a red floor.
    pub(super) fn with_red_floor(self) -> Self {
        // What follows the floor goes on in its white.
        let floor = "usemtl white\nf 1 2 3 4\n";
        Self { obj: self.obj.replace(floor, "usemtl red\nf 1 2 3 4\nusemtl white\n"), ..self }
    }

    /// With another light.
    pub(super) fn lit_by(self, change: impl Fn(&mut AreaLightState)) -> Self {
        let mut light = self.light.unwrap_or_default();
        change(&mut light);
        Self { light: Some(light), ..self }
    }

    /// With these reflectances for the Cornell box's white, red and green.
    pub(super) fn reflecting(self, reflectance: f64) -> Self {
        let line = |line: &str| {
            let is_reflectance = line.trim_start().starts_with("Kd ");
            if is_reflectance { format!("Kd {reflectance} {reflectance} {reflectance}") } else { String::from(line) }
        };
        let lines: Vec<String> = self.mtl.lines().map(line).collect();
        Self { mtl: lines.join("\n") + "\n", ..self }
    }
}
