//! What is said of scenes whose light meets the backs of surfaces, and of which nothing is said.
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

mod common;

use std::{fmt::Write as _, sync::Arc};

use common::{cornell_light, own_scene};
use glam::DVec3;
use radiosity::{
    scene::{LoadOptions, area_light::AreaLightState, load::load_from_memory},
    trace::Tracer,
    transport::facing::{Facing, Remedy, facing},
};

const MTL: &str = "newmtl wall\nKd 0.5 0.5 0.5\nnewmtl floor\nKd 0.5 0.5 0.5\nnewmtl shade\nKd 0.5 0.5 0.5\n\
                   newmtl lamp\nKd 0 0 0\nKe 10 10 10\n";

/// Quadrangles as OBJ text.
#[derive(Default)]
struct Obj {
    text: String,
    vertices: usize,
}

impl Obj {
    /// A quadrangle with these corners, counter-clockwise seen from its front.
    fn quad(mut self, material: &str, corners: [DVec3; 4]) -> Self {
        corners.iter().for_each(|corner| writeln!(self.text, "v {} {} {}", corner.x, corner.y, corner.z).unwrap());
        let first = self.vertices + 1;
        writeln!(self.text, "usemtl {material}\nf {} {} {} {}", first, first + 1, first + 2, first + 3).unwrap();
        self.vertices += 4;
        self
    }

    /// A level square that looks up, or down.
    fn level(self, material: &str, half: f64, height: f64, looks_up: bool) -> Self {
        let [a, b, c, d] =
            [[-1.0, -1.0], [-1.0, 1.0], [1.0, 1.0], [1.0, -1.0]].map(|[x, z]| DVec3::new(x * half, height, z * half));
        self.quad(material, if looks_up { [a, b, c, d] } else { [a, d, c, b] })
    }

    /// Four walls around the middle, from one height to another, that look inwards, or outwards.
    fn walls(mut self, material: &str, half: f64, [low, high]: [f64; 2], look_in: bool) -> Self {
        for side in 0..4 {
            let corner = |turn: usize, y: f64| {
                let [x, z] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]][turn % 4];
                DVec3::new(x * half, y, z * half)
            };
            let [a, b, c, d] = [corner(side, low), corner(side + 1, low), corner(side + 1, high), corner(side, high)];
            self = self.quad(material, if look_in { [a, b, c, d] } else { [d, c, b, a] });
        }
        self
    }

    fn said(&self, light: Option<AreaLightState>, load: &LoadOptions) -> Option<Facing> {
        let scene = Arc::new(load_from_memory("scene", &self.text, MTL, load).unwrap());
        let light = light.map(|light| light.to_local(&scene.frame));
        facing(&scene, &Tracer::new(Arc::clone(&scene)), light.as_ref(), load)
    }

    fn said_of_it(&self) -> Option<Facing> {
        self.said(None, &LoadOptions::default())
    }
}

/// A room of 4 m by 4 m by 2 m. `is_right`: it looks inwards.
fn room(is_right: bool) -> Obj {
    Obj::default().level("floor", 2.0, 0.0, is_right).level("wall", 2.0, 2.0, !is_right).walls(
        "wall",
        2.0,
        [0.0, 2.0],
        is_right,
    )
}

/// A small light in the room, shining down.
const LIGHT: AreaLightState =
    AreaLightState { centre: [0.0, 1.5, 0.0], u: [0.1, 0.0, 0.0], v: [0.0, 0.0, 0.1], radiance: [10.0; 3] };

fn flipped() -> LoadOptions {
    LoadOptions { flip: true, ..LoadOptions::default() }
}

#[test]
fn a_room_that_is_wound_outwards_is_named_with_its_remedy_whatever_lights_it() {
    let lamp_below = room(false).level("lamp", 0.3, 1.9, true);
    let lamp_flush = room(false).level("lamp", 0.3, 2.0, true);
    for (scene, light) in [(room(false), Some(LIGHT)), (lamp_below, None), (lamp_flush, None), (room(false), None)] {
        let said = scene.said(light, &LoadOptions::default()).unwrap();
        assert_eq!(said.remedy, Remedy::Flip, "{}", said.text);
        assert!(said.text.contains("--flip"), "{}", said.text);
        assert_eq!(scene.said(light, &flipped()), None);
        let two_sided = LoadOptions { two_sided: true, ..LoadOptions::default() };
        assert_eq!(scene.said(light, &two_sided), None);
    }
    let said = room(false).said(Some(LIGHT), &LoadOptions::default()).unwrap();
    assert!(said.text.starts_with("100 % of the light first meets back faces, most of them of `"), "{}", said.text);
}

#[test]
fn a_room_that_is_flipped_though_it_is_right_is_not_to_be_flipped() {
    let said = room(true).said(Some(LIGHT), &flipped()).unwrap();
    assert!(said.text.contains("leave out --flip"), "{}", said.text);
}

/// Expected: of a low light over a wide floor the floor gets nearly all.
#[test]
fn a_floor_alone_that_is_wound_the_wrong_way_is_named_and_wants_two_sides() {
    let scene = Obj::default().level("floor", 2.0, 0.0, false).level("wall", 2.0, 2.0, false).walls(
        "wall",
        2.0,
        [0.0, 2.0],
        true,
    );
    let low = AreaLightState { centre: [0.0, 0.9, 0.0], ..LIGHT };
    let said = scene.said(Some(low), &LoadOptions::default()).unwrap();
    assert_eq!(said.remedy, Remedy::TwoSided, "{}", said.text);
    assert!(said.text.contains("of `floor`") && said.text.contains("--two-sided"), "{}", said.text);
}

#[test]
fn of_scenes_that_are_right_nothing_is_said() {
    let ground = || Obj::default().level("floor", 20.0, 0.0, true);
    // A bulb in a shade of one side, open above and below: three quarters of its light meet the shade from behind.
    let shaded = |around: Obj| around.walls("lamp", 0.03, [0.95, 1.05], false).walls("shade", 0.1, [0.85, 1.15], false);
    let scenes = [
        ("room", room(true)),
        ("room with a lamp", room(true).level("lamp", 0.3, 1.9, false)),
        ("lamp under a shade in a room", shaded(room(true))),
        ("lamp under a shade outdoors", shaded(ground())),
        ("lamp over the ground", ground().walls("lamp", 0.03, [0.95, 1.05], false)),
        ("lamp that shines up from the ground", ground().level("lamp", 0.3, 0.1, true)),
        ("ground alone", ground()),
    ];
    for (name, scene) in scenes {
        assert_eq!(scene.said_of_it(), None, "{name}");
    }
    assert_eq!(room(true).said(Some(LIGHT), &LoadOptions::default()), None);
    // One body that is lit from afar: a box seen from outside.
    let body = Obj::default().level("floor", 0.2, 0.0, false).level("wall", 0.2, 0.4, true).walls(
        "wall",
        0.2,
        [0.0, 0.4],
        false,
    );
    let far = AreaLightState { centre: [0.0, 20.0, 0.0], ..LIGHT };
    assert_eq!(body.said(Some(far), &LoadOptions::default()), None);
    let cornell = own_scene("cornell/cornell", &LoadOptions::default());
    let light = cornell_light().to_local(&cornell.frame);
    assert_eq!(facing(&cornell, &Tracer::new(Arc::clone(&cornell)), Some(&light), &LoadOptions::default()), None);
}

/// Each side of a room is lit from within its own; the scene's size and place change nothing.
#[test]
fn a_scene_says_the_same_at_any_size_and_place() {
    let said = |scale: f64, shift: f64| {
        let mut scene = Obj::default();
        for line in room(false).text.lines() {
            let mut words = line.split(' ');
            if words.next() == Some("v") {
                let [x, y, z] = [0; 3].map(|_| words.next().unwrap().parse::<f64>().unwrap() * scale + shift);
                writeln!(scene.text, "v {x} {y} {z}").unwrap();
            } else {
                writeln!(scene.text, "{line}").unwrap();
            }
        }
        let light = AreaLightState {
            centre: LIGHT.centre.map(|value| value * scale + shift),
            u: LIGHT.u.map(|value| value * scale),
            v: LIGHT.v.map(|value| value * scale),
            ..LIGHT
        };
        scene.said(Some(light), &LoadOptions::default())
    };
    let expected = said(1.0, 0.0);
    assert!(expected.is_some());
    for (scale, shift) in [(1e-4, 0.0), (1e4, 0.0), (1.0, 1e5)] {
        assert_eq!(said(scale, shift), expected, "{scale} {shift}");
    }
}
