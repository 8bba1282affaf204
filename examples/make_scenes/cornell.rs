//! The Cornell box, from the coordinates that the Cornell University Program of Computer Graphics published
//! ("Cornell Box Data", in millimetres). Its spectra are here as common RGB reflectances.

use glam::DVec3;

use super::File;
use super::obj::{Corner, Obj};

const MTL: &str = "\
# Reflectances of the Cornell box as linear RGB
newmtl white
Kd 0.76 0.75 0.73

newmtl red
Kd 0.63 0.065 0.05

newmtl green
Kd 0.15 0.48 0.09
";

type Quad = [[f64; 3]; 4];

const WALLS: [(&str, &str, Quad); 5] = [
    ("floor", "white", [[552.8, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 559.2], [549.6, 0.0, 559.2]]),
    ("ceiling", "white", [[556.0, 548.8, 0.0], [556.0, 548.8, 559.2], [0.0, 548.8, 559.2], [0.0, 548.8, 0.0]]),
    ("back_wall", "white", [[549.6, 0.0, 559.2], [0.0, 0.0, 559.2], [0.0, 548.8, 559.2], [556.0, 548.8, 559.2]]),
    ("right_wall", "green", [[0.0, 0.0, 559.2], [0.0, 0.0, 0.0], [0.0, 548.8, 0.0], [0.0, 548.8, 559.2]]),
    ("left_wall", "red", [[552.8, 0.0, 0.0], [549.6, 0.0, 559.2], [556.0, 548.8, 559.2], [556.0, 548.8, 0.0]]),
];

/// The blocks' tops (x, z), counter-clockwise from above, and their heights.
const BLOCKS: [(&str, f64, [[f64; 2]; 4]); 2] = [
    ("short_block", 165.0, [[130.0, 65.0], [82.0, 225.0], [240.0, 272.0], [290.0, 114.0]]),
    ("tall_block", 330.0, [[423.0, 247.0], [265.0, 296.0], [314.0, 456.0], [472.0, 406.0]]),
];

pub(super) fn files() -> Vec<File> {
    let mut obj = Obj::default();
    for (name, material, quad) in WALLS {
        obj.object(name);
        obj.material(material);
        add_quad(&mut obj, quad);
    }
    for (name, height, top) in BLOCKS {
        obj.object(name);
        obj.material("white");
        let at = |corner: usize, y: f64| [top[corner % 4][0], y, top[corner % 4][1]];
        add_quad(&mut obj, [at(0, height), at(1, height), at(2, height), at(3, height)]);
        for corner in 0..4 {
            add_quad(&mut obj, [at(corner, 0.0), at(corner + 1, 0.0), at(corner + 1, height), at(corner, height)]);
        }
    }
    let comment = "The Cornell box (Cornell University Program of Computer Graphics), in metres; its front is open";
    vec![File::text("cornell/cornell.obj", obj.text(comment, "cornell.mtl")), File::text("cornell/cornell.mtl", MTL)]
}

fn add_quad(obj: &mut Obj, quad: Quad) {
    let corner = |millimetres| Corner { position: DVec3::from_array(millimetres) / 1e3, texcoord: None, normal: None };
    obj.face(&quad.map(corner));
}
