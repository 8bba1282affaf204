//! A white room with one boldly painted wall.

use glam::{DAffine3, DVec2, DVec3};

use super::File;
use super::model::Model;
use super::picture;
use super::shapes::cells;

const MTL: &str = "\
newmtl white
Kd 0.8 0.8 0.8

newmtl floor
Kd 0.7 0.68 0.64

newmtl painted
Kd 0.9 0.9 0.9
map_Kd bleeding.png
";

/// The room is this wide (x), high and long (z) [m].
const SIZE: DVec3 = DVec3::new(4.0, 3.0, 5.0);
const CELL: f64 = 0.25;

pub(super) fn files() -> anyhow::Result<Vec<File>> {
    let mut model = Model::default();
    room(&mut model);
    boxes(&mut model);
    let comment = "A room with a painted wall: colour bleeding; in metres, closed, seen from inside";
    Ok(vec![
        File::text("bleeding/bleeding.obj", model.obj.text(comment, "bleeding.mtl")),
        File::text("bleeding/bleeding.mtl", MTL),
        picture::png("bleeding/bleeding.png", [512, 512], picture::bold_wall)?,
    ])
}

fn room(model: &mut Model) {
    let (width, height, length) = (DVec3::X * SIZE.x, DVec3::Y * SIZE.y, DVec3::Z * SIZE.z);
    model.obj.object("walls");
    model.obj.material("white");
    model.rectangle(height, width, length, CELL);
    model.rectangle(DVec3::ZERO, width, height, CELL);
    model.rectangle(width + length, -width, height, CELL);
    model.rectangle(width, length, height, CELL);
    model.obj.object("floor");
    model.obj.material("floor");
    model.rectangle(DVec3::ZERO, length, width, CELL);
    // The painted wall, x = 0: one square of the pattern is 0.6 m wide, so the picture 2.4 m.
    model.obj.object("painted_wall");
    model.obj.material("painted");
    model.textured_patch(
        [cells(SIZE.z, CELL), cells(SIZE.y, CELL)],
        |u, v| (1.0 - u) * length + v * height,
        |u, v| DVec2::new(u * SIZE.z, v * SIZE.y) / 2.4,
    );
}

fn boxes(model: &mut Model) {
    model.obj.material("white");
    for (name, place, size, turn) in [
        ("tall_box", DVec3::new(1.35, 0.0, 1.3), DVec3::new(0.7, 1.7, 0.7), 24.0_f64),
        ("low_box", DVec3::new(2.75, 0.0, 2.1), DVec3::new(0.9, 0.8, 0.9), -18.0),
        ("step", DVec3::new(1.05, 0.0, 2.75), DVec3::new(0.6, 0.35, 0.6), 40.0),
    ] {
        model.obj.object(name);
        model.frame = DAffine3::from_translation(place) * DAffine3::from_rotation_y(turn.to_radians());
        let half = DVec3::new(size.x / 2.0, 0.0, size.z / 2.0);
        model.block(-half, half + DVec3::Y * size.y, CELL / 2.0, &[DVec3::NEG_Y]);
    }
    model.frame = DAffine3::IDENTITY;
}
