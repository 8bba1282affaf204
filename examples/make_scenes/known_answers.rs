//! Scenes whose irradiance is known in closed form; see `scenes/tests/README.txt`.

use std::f64::consts::{FRAC_1_PI, PI};

use glam::DVec3;

use super::File;
use super::model::Model;
use super::obj::short;

pub(super) fn files() -> Vec<File> {
    let mut files: Vec<File> = [30, 50, 80, 95].into_iter().flat_map(furnace).collect();
    files.extend(plates("parallel-plates", "Two unit squares, 1 m apart, face to face", |model| {
        // Facing down, above the lower one.
        model.rectangle(DVec3::Y, DVec3::X, DVec3::Z, 0.0625);
    }));
    files.extend(plates("perpendicular-plates", "Two unit squares at a right angle, with a common edge", |model| {
        model.rectangle(DVec3::ZERO, DVec3::X, DVec3::Y, 0.0625);
    }));
    files.extend(sphere_in_box());
    files
}

fn pair(name: &str, comment: &str, model: &Model, mtl: String) -> [File; 2] {
    [
        File::text(format!("tests/{name}.obj"), model.obj.text(comment, &format!("{name}.mtl"))),
        File::text(format!("tests/{name}.mtl"), mtl),
    ]
}

/// A material that reflects and emits the same in all bands; M = π L_e = 1 W/m² where it emits.
fn grey(name: &str, reflectance: f64, radiance: f64) -> String {
    let (kd, ke) = (short(reflectance, 4), short(radiance, 8));
    format!("newmtl {name}\nKd {kd} {kd} {kd}\nKe {ke} {ke} {ke}\n")
}

/// A closed unit cube that emits the same everywhere: each point sees the same radiance in all directions.
fn furnace(percent: u32) -> [File; 2] {
    let mut model = Model::default();
    model.obj.object("cube");
    model.obj.material("wall");
    model.room(DVec3::ZERO, DVec3::ONE, 0.125);
    let comment = format!("A closed cube of reflectance {percent} % that emits 1 W/m2 everywhere, seen from inside");
    pair(&format!("furnace-{percent}"), &comment, &model, grey("wall", f64::from(percent) / 100.0, FRAC_1_PI))
}

/// The unit square y = 0, which emits upwards, and a black receiver.
fn plates(name: &str, comment: &str, receiver: impl Fn(&mut Model)) -> [File; 2] {
    let mut model = Model::default();
    model.obj.object("emitter");
    model.obj.material("emitter");
    model.rectangle(DVec3::ZERO, DVec3::Z, DVec3::X, 0.0625);
    model.obj.object("receiver");
    model.obj.material("receiver");
    receiver(&mut model);
    pair(name, comment, &model, grey("emitter", 0.0, FRAC_1_PI) + "\n" + &grey("receiver", 0.0, 0.0))
}

/// A furnace with something in it, which must change nothing.
fn sphere_in_box() -> [File; 2] {
    let mut model = Model::default();
    model.obj.object("box");
    model.obj.material("wall");
    model.room(DVec3::splat(-1.0), DVec3::splat(1.0), 0.25);
    model.obj.object("sphere");
    model.obj.material("sphere");
    let ring = |index: i32| {
        let (sine, cosine) = (f64::from(index) / 24.0 * PI).sin_cos();
        [0.5 * sine, -0.5 * cosine]
    };
    model.lathe(DVec3::ZERO, &(0..=24).map(ring).collect::<Vec<_>>(), 48);
    let comment = "A sphere in a closed box; both emit 1 W/m2 and reflect half";
    pair("sphere-in-box", comment, &model, grey("wall", 0.5, FRAC_1_PI) + "\n" + &grey("sphere", 0.5, FRAC_1_PI))
}
