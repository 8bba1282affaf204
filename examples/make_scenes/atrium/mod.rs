//! An open court with two storeys of arcades, vaulted galleries and banners: about 30 m by 16 m.
//!
//! Each of the four sides is built in its own frame: x runs along the arcade with 0 in its middle, z = 0 is the
//! middle of the arcade's wall, and +z looks into the court.

mod arcade;
mod columns;
mod furniture;
mod galleries;

use glam::{DAffine3, DVec3};

use super::File;
use super::model::Model;
use super::picture;

const MTL: &str = include_str!("materials.mtl");

/// From one column to the next [m].
const BAY: f64 = 3.0;
/// From the middle of the court to the arcades of its long sides, and of its ends.
const HALF_WIDTH: f64 = 4.5;
const HALF_LENGTH: f64 = 12.0;
/// Half the thickness of the arcades' walls.
const HALF_WALL: f64 = 0.25;
/// From the middle of an arcade to the inside and the outside of the wall behind the gallery.
const GALLERY: f64 = 3.5;
const OUTSIDE: f64 = 4.0;
/// The kerb below the columns: its height and how far it stands out.
const KERB: f64 = 0.15;
const KERB_EDGE: f64 = 0.45;
/// Heights of the upper floor, of the upper ceiling and of the roof.
const UPPER_FLOOR: f64 = 5.2;
const CEILING: f64 = 9.4;
const ROOF: f64 = 10.0;
/// How far the band below the upper floor and the cornice stand out.
const BAND_EDGE: f64 = HALF_WALL + 0.14;
const CORNICE_EDGE: f64 = HALF_WALL + 0.32;

/// One storey's arcade.
#[derive(Clone, Copy)]
struct Storey {
    floor: f64,
    /// Where the arches spring: the top of the columns.
    spring: f64,
    /// Where the wall above the arches ends.
    top: f64,
    arch_radius: f64,
    column: columns::Column,
}

const STOREYS: [Storey; 2] = [
    Storey { floor: KERB, spring: 3.3, top: 4.85, arch_radius: 1.2, column: columns::GROUND },
    Storey { floor: UPPER_FLOOR, spring: 7.8, top: 9.55, arch_radius: 1.25, column: columns::UPPER },
];

/// One side of the court.
#[derive(Clone, Copy)]
struct Side {
    frame: DAffine3,
    /// Half the length of its arcade.
    half: f64,
}

impl Side {
    fn bays(&self) -> usize {
        (2.0 * self.half / BAY).round() as usize
    }

    /// Where the column between bay `index` - 1 and bay `index` stands.
    fn column_x(&self, index: usize) -> f64 {
        index as f64 * BAY - self.half
    }
}

fn sides() -> [Side; 4] {
    [0, 1, 2, 3].map(|quarter| {
        let (half, depth) = if quarter % 2 == 0 { (HALF_LENGTH, HALF_WIDTH) } else { (HALF_WIDTH, HALF_LENGTH) };
        let turn = DAffine3::from_rotation_y(f64::from(quarter) * std::f64::consts::FRAC_PI_2);
        Side { frame: turn * DAffine3::from_translation(DVec3::new(0.0, 0.0, -depth)), half }
    })
}

pub(super) fn files() -> anyhow::Result<Vec<File>> {
    let mut model = Model::default();
    for side in sides() {
        model.frame = side.frame;
        for storey in &STOREYS {
            arcade::arches(&mut model, &side, storey);
            columns::row(&mut model, &side, storey);
        }
        arcade::mouldings(&mut model, &side);
        arcade::balustrade(&mut model, &side);
        galleries::floors(&mut model, &side);
        galleries::walls(&mut model, &side);
        galleries::vaults(&mut model, &side);
        galleries::upper_ceiling(&mut model, &side);
        galleries::doors(&mut model, &side);
        furniture::banners(&mut model, &side);
    }
    model.frame = DAffine3::IDENTITY;
    furniture::court(&mut model);

    let comment = "An atrium with two storeys of arcades, in metres; written by the example make_scenes";
    let mut files = vec![
        File::text("atrium/atrium.obj", model.obj.text(comment, "atrium.mtl")),
        File::text("atrium/atrium.mtl", MTL),
        picture::png("atrium/court_tiles.png", [512, 512], picture::court_tiles)?,
        picture::png("atrium/gallery_tiles.png", [256, 256], picture::gallery_tiles)?,
        picture::png("atrium/masonry.png", [512, 512], picture::masonry)?,
        picture::png("atrium/banner_hem.png", [128, 384], picture::banner_hem)?,
    ];
    let emblems: [(&str, u32, u32, fn(glam::DVec2) -> f64); 3] = [
        ("red", 0xa61e22, 0xe8b84a, picture::sun),
        ("blue", 0x1f4aa0, 0xe6e0d0, picture::star),
        ("green", 0x1e7a46, 0xecc75a, picture::leaf),
    ];
    for (name, cloth, thread, emblem) in emblems {
        let path = format!("atrium/banner_{name}.png");
        files.push(picture::png(&path, [256, 768], |place| picture::banner(place, cloth, thread, emblem))?);
    }
    Ok(files)
}
