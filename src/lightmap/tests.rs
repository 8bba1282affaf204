use std::sync::Arc;

use glam::{Vec2, Vec3};

use super::*;
use crate::{
    scene::{LoadOptions, builtin, load},
    trace::Tracer,
};

fn atlas(scene: &Arc<Scene>, settings: &LightmapSettings) -> Atlas {
    Atlas::new(scene, &Tracer::new(Arc::clone(scene)), settings, &|_, _| true).unwrap().unwrap()
}

fn cornell() -> Arc<Scene> {
    Arc::new(builtin::cornell(&LoadOptions::default()).unwrap())
}

fn from_obj(obj: &str, mtl: &str, options: &LoadOptions) -> Arc<Scene> {
    Arc::new(load::load_from_memory("test", obj, mtl, options).unwrap())
}

fn scene_area(scene: &Scene) -> f32 {
    (0..scene.mesh.triangles.len() as u32).map(|triangle| scene.mesh.area(triangle)).sum()
}

#[test]
fn the_texels_have_the_area_of_the_scene_and_lie_on_it() {
    let scene = cornell();
    let atlas = atlas(&scene, &LightmapSettings { texels_per_metre: Some(58.0), ..LightmapSettings::default() });
    let area: f64 = atlas.texels.iter().map(|texel| f64::from(texel.area)).sum();
    let expected = f64::from(scene_area(&scene));
    assert!((area / expected - 1.0).abs() < 1e-5, "{area} of {expected}");
    for texel in &atlas.texels {
        let [a, _, _] = scene.mesh.corners(texel.triangle);
        assert!((texel.position - a).dot(texel.geometric_normal).abs() < 1e-5, "{texel:?}");
        assert!(texel.geometric_normal.is_normalized() && texel.shading_normal.is_normalized());
        // A step to the next texel of the row or the column is 1/58 m long.
        let step = 1.0 / (58.0 * scene.frame.metres_per_unit as f32);
        assert!(texel.steps.iter().all(|found| (found.length() / step - 1.0).abs() < 1e-3), "{texel:?}");
    }
}

#[test]
fn no_texel_is_shared_by_two_charts_and_gutters_lie_between() {
    let atlas = atlas(&cornell(), &LightmapSettings { texels: 3000, ..LightmapSettings::default() });
    let charts = &atlas.charts;
    let mut owner = vec![u32::MAX; charts.pixel_count()];
    for texel in &atlas.texels {
        assert_eq!(std::mem::replace(&mut owner[texel.pixel as usize], texel.chart), u32::MAX);
    }
    for texel in &atlas.texels {
        let [page, column, row] = charts.place(texel.pixel as usize);
        for (x, y) in [(1, 0), (0, 1), (2, 0), (0, 2)] {
            let (x, y) = (column + x, row + y);
            if x < charts.page_size[0] && y < charts.page_size[1] {
                let beside = owner[charts.pixel(page, x, y)];
                assert!(beside == u32::MAX || beside == texel.chart, "{column} {row}");
            }
        }
    }
}

#[test]
fn a_linear_field_is_read_back_at_any_point_of_the_surface() {
    // A bilinear read of texel centres has a linear field exactly; at the rim it reads the gutter, which does not.
    let scene = cornell();
    let atlas = atlas(&scene, &LightmapSettings { texels: 20_000, ..LightmapSettings::default() });
    let values: Vec<Vec3> = atlas.texels.iter().map(|texel| texel.position + 2.0).collect();
    let buried = atlas.texels.iter().filter(|texel| texel.open == 0.0).count();
    assert!(buried > 50, "the floor under the blocks: {buried}");
    let pages = pages_of(&atlas.charts, &atlas.texels, &values);
    let step = atlas.texels[0].steps[0].length();
    let (mut at_rim, mut count) = (0, 0);
    for triangle in 0..10 {
        for index in 0..200 {
            let (u, v) = ((index as f32 * 0.618).fract(), (index as f32 * 0.755).fract());
            let barycentric = if u + v > 1.0 { Vec2::new(1.0 - u, 1.0 - v) } else { Vec2::new(u, v) };
            let found = atlas.charts.interpolate(&pages, triangle, barycentric) - 2.0;
            let expected = scene.mesh.position(triangle, barycentric);
            let apart = found.distance(expected) / step;
            count += 1;
            at_rim += usize::from(apart > 0.01);
            // Under a block the read is a mean of what lies around it.
            assert!(apart < 1.0 || expected.y < -0.9 * scene.mesh.positions[0].y.abs(), "{apart} texels at {expected}");
        }
    }
    assert!(at_rim < count / 4, "{at_rim} of {count}");
}

#[test]
fn a_texel_half_under_an_object_is_half_open_and_stands_in_its_open_half() {
    // A floor of 4 m, and an open box without a bottom over the part x > 2.25 of it, at 1 texel a metre. The box hangs a tenth
    // of a millimetre above the floor: if it stood there, the floor would be cut at its foot.
    let floor = "v 0 0 0\nv 0 0 4\nv 4 0 4\nv 4 0 0\nf 1 2 3 4\n";
    let walls = "v 2.25 1e-4 -1\nv 2.25 1e-4 5\nv 2.25 2 5\nv 2.25 2 -1\nf 5 6 7 8\nv 9 2 -1\nv 9 2 5\nf 8 7 10 9\nv 9 1e-4 5\nv 9 1e-4 -1\n\
                 f 10 11 12 9\nf 6 11 10 7\nf 12 5 8 9\n";
    let scene = from_obj(&format!("{floor}{walls}"), "", &LoadOptions::default());
    let atlas = atlas(&scene, &LightmapSettings { texels_per_metre: Some(1.0), ..LightmapSettings::default() });
    let floor_texels: Vec<&Texel> = atlas.texels.iter().filter(|texel| texel.triangle < 2).collect();
    let open: f32 = floor_texels.iter().map(|texel| texel.open_area()).sum();
    let square_metres = scene.frame.square_metres_per_unit() as f32;
    assert!((open * square_metres - 2.25 * 4.0).abs() < 0.7, "{}", open * square_metres);
    for texel in floor_texels.iter().filter(|texel| texel.open > 0.0) {
        assert!(scene.frame.point_to_metres(texel.position).x < 2.25, "{texel:?}");
    }
    assert!(floor_texels.iter().any(|texel| texel.open > 0.0 && texel.open < 1.0));
}

#[test]
fn own_texture_coordinates_are_used_when_no_two_triangles_share_a_place() {
    let quad = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 1 0 1\nv 1 1 1\n";
    let unique = "vt 0 0\nvt .4 0\nvt .4 .4\nvt 0 .4\nvt .5 0\nvt .9 0\nvt .9 .4\nvt .5 .4\n";
    let faces = "f 1/1 2/2 3/3 4/4\nf 2/5 5/6 6/7 3/8\n";
    let scene = from_obj(&format!("{quad}{unique}{faces}"), "", &LoadOptions::default());
    let settings = LightmapSettings { texels: 2000, ..LightmapSettings::default() };
    let found = unwrap(&scene, &settings, &|_, _| true).unwrap().unwrap();
    let side = found.page_size[0] as f32;
    assert!(found.coordinates[0][1].abs_diff_eq(Vec2::new(0.4 * side, 0.0), 1e-3), "{:?}", found.coordinates[0]);
    assert!(found.chart_of_triangle[0] == found.chart_of_triangle[1]);
    assert!(found.chart_of_triangle[1] != found.chart_of_triangle[2]);
    // Both faces in one place: new coordinates, on which they lie apart.
    let shared =
        from_obj(&format!("{quad}{unique}f 1/1 2/2 3/3 4/4\nf 2/1 5/2 6/3 3/4\n"), "", &LoadOptions::default());
    let found = unwrap(&shared, &settings, &|_, _| true).unwrap().unwrap();
    let centre = |triangle: u32| found.map_point(triangle, Vec2::splat(1.0 / 3.0));
    assert!(centre(0).distance(centre(2)) > 5.0);
}

#[test]
fn the_two_sides_of_a_surface_have_texels_of_their_own() {
    let quad = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
    let scene = from_obj(quad, "", &LoadOptions { two_sided: true, ..LoadOptions::default() });
    let atlas = atlas(&scene, &LightmapSettings { texels: 500, ..LightmapSettings::default() });
    let front = |texel: &&Texel| texel.geometric_normal.z > 0.5;
    let (fronts, all) = (atlas.texels.iter().filter(front).count(), atlas.texels.len());
    assert_eq!(2 * fronts, all);
    assert!(atlas.texels.iter().all(|texel| texel.open == 1.0), "the other side hides nothing");
}

#[test]
fn a_large_map_takes_several_pages() {
    let settings = LightmapSettings { texels: 40_000, page_size: 128, ..LightmapSettings::default() };
    let atlas = atlas(&cornell(), &settings);
    assert!(atlas.charts.page_count > 2 && atlas.charts.page_size == [128; 2], "{:?}", atlas.charts.page_size);
    let last = atlas.charts.page_count - 1;
    assert!(atlas.texels.iter().any(|texel| atlas.charts.place(texel.pixel as usize)[0] == last));
}

#[test]
fn unwrapping_and_measuring_stop_when_told_to() {
    let scene = cornell();
    let tracer = Tracer::new(Arc::clone(&scene));
    for stage in ["packing charts", "measuring texels"] {
        let settings = LightmapSettings::default();
        let stopped = Atlas::new(&scene, &tracer, &settings, &|at: &str, _| at != stage).unwrap();
        assert!(stopped.is_none(), "{stage}");
    }
}

#[test]
fn nonsense_is_refused_in_one_line() {
    let scene = cornell();
    let refusal = |settings: LightmapSettings| unwrap(&scene, &settings, &|_, _| true).unwrap_err();
    let density = |density| LightmapSettings { texels_per_metre: Some(density), ..LightmapSettings::default() };
    for settings in [density(0.0), density(f64::NAN), density(1e9)] {
        assert!(!refusal(settings).contains('\n'));
    }
    assert!(refusal(LightmapSettings { texels: 0, ..LightmapSettings::default() }).contains("texels"));
}
