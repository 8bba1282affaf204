//! Radiosity on the graphics card: passes with known answers, and the Cornell box against the truth.
#![cfg(feature = "gpu")]
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

mod common;

use std::{sync::Arc, time::Instant};

use glam::{DVec3, Vec3};
use radiosity::{
    check::{
        metrics::{Field, FieldErrors, field_errors},
        surface_points::locate,
    },
    gpu::{
        device,
        lightmap::{GpuSettings, GpuSolver},
    },
    lightmap::{Atlas, LightmapSettings, pages_of},
    scene::{AreaLight, Scene},
    trace::Tracer,
};

fn card() -> (wgpu::Device, wgpu::Queue) {
    device::headless().unwrap()
}

/// 32 texels along a wall of 0.556 m.
fn cornell_map() -> LightmapSettings {
    LightmapSettings { texels_per_metre: Some(32.0 / 0.556), ..LightmapSettings::default() }
}

fn errors_against(
    case: &common::truths::Case,
    tracer: &Tracer,
    atlas: &Atlas,
    direct: &[Vec3],
    total: &[Vec3],
) -> FieldErrors {
    let [direct, total] = [direct, total].map(|values| pages_of(&atlas.charts, &atlas.texels, values));
    let places: Vec<_> = case.points.iter().map(|point| locate(&case.scene, tracer, point).unwrap()).collect();
    let at = |pages: &[Vec3]| -> Vec<DVec3> {
        places.iter().map(|(triangle, place)| atlas.charts.interpolate(pages, *triangle, *place).as_dvec3()).collect()
    };
    let (direct, total) = (at(&direct), at(&total));
    let known: (Vec<_>, Vec<_>) = case.values.iter().map(|value| (value.direct, value.total)).unzip();
    field_errors(Field { direct: &direct, total: &total }, Field { direct: &known.0, total: &known.1 })
}

fn solver(scene: &Arc<Scene>, atlas: &Atlas, light: Option<AreaLight>, settings: &GpuSettings) -> GpuSolver {
    let (device, queue) = card();
    GpuSolver::new((&device, &queue), scene, atlas, light.as_ref(), settings).unwrap()
}

#[test]
fn experiment() {
    let Some(case) = common::truths::case("cornell", "cornell/cornell.obj", 1) else { return };
    let tracer = Tracer::new(case.scene.clone());
    let started = Instant::now();
    let atlas = Atlas::new(&case.scene, &tracer, &cornell_map(), &|_, _| true).unwrap().unwrap();
    println!("atlas {:?} {} texels in {:?}", atlas.charts.page_size, atlas.texels.len(), started.elapsed());
    let light = case.light.map(|light| light.to_local(&case.scene.frame));
    for settings in experiments() {
        let started = Instant::now();
        let mut solver = solver(&case.scene, &atlas, light, &settings);
        let built = started.elapsed();
        while !solver.is_done() {
            solver.step().unwrap();
        }
        let seconds = started.elapsed();
        let ledger = *solver.ledger();
        let fields = solver.fields().unwrap();
        let errors = errors_against(&case, &tracer, &atlas, &fields.direct, &fields.total).lit;
        println!("{settings:?}");
        println!(
            "  built {built:?}, total {seconds:?}, {} shooters {} batches, balance {:.3} %, escaped {:.2} %, unabsorbed {:.3} %",
            ledger.shooters,
            ledger.batches,
            100.0 * ledger.balance(),
            100.0 * ledger.escaped.element_sum() / ledger.emitted.element_sum(),
            100.0 * ledger.unabsorbed()
        );
        println!(
            "  error {:.2} %, direct {:.2} %, indirect {:.2} %, bias {:.2} % (direct {:.2} %)",
            100.0 * errors.total.relative_l2,
            100.0 * errors.direct.relative_l2,
            100.0 * errors.indirect.relative_l2,
            100.0 * errors.total.bias,
            100.0 * errors.direct.bias
        );
    }
}

fn experiments() -> Vec<GpuSettings> {
    let base = GpuSettings { unabsorbed: 0.001, ..GpuSettings::default() };
    vec![
        base.clone(),
        GpuSettings { unabsorbed: 0.01, ..base.clone() },
        GpuSettings { group: 1, hemicube: 64, ..base.clone() },
        GpuSettings { hemicube: 128, ..base.clone() },
        GpuSettings { bias: 0.1, ..base.clone() },
        GpuSettings { bias: 1.0, ..base.clone() },
        GpuSettings { light_side: 16, ..base.clone() },
        GpuSettings { no_filter: true, ..base.clone() },
    ]
}
