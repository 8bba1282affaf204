//! What a solve says it did not do, and what that would have taken.
#![cfg(feature = "reference")]
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

mod common;

use common::{cornell_light, own_scene, problem, solve_unwatched};
use radiosity::{
    scene::LoadOptions,
    solver::{SolveReport, SolveSettings},
    transport::lights::DirectMethod,
};

fn report(settings: SolveSettings) -> SolveReport {
    let scene = own_scene("cornell/cornell", &LoadOptions::default());
    solve_unwatched(&problem(&scene, Some(cornell_light()), settings)).1
}

fn even() -> SolveSettings {
    SolveSettings { rays: 64, bounces: Some(4), subdivide: 3, ..SolveSettings::even() }
}

fn following() -> SolveSettings {
    SolveSettings { adaptive: 0.1, rays: 64, bounces: Some(4), ..SolveSettings::default() }
}

/// The line that tells of it.
fn line(report: &SolveReport, what: &str) -> String {
    let lines = report.skipped();
    lines.iter().find(|line| line.contains(what)).unwrap_or_else(|| panic!("no {what} in {lines:?}")).clone()
}

#[test]
fn what_was_saved_is_in_proportion_to_what_was_skipped_at_the_pace_of_what_was_done() {
    for settings in [even(), following()] {
        let report = report(settings);
        let saved = report.seconds_saved;
        let by_ray = report.gather_thread_seconds / report.gather_rays as f64;
        assert!(by_ray > 1e-9 && by_ray < 1e-3, "{by_ray} s a ray");
        let expected = [report.gather_rays_skipped, report.gather_rays_reused].map(|rays| by_ray * rays as f64);
        for (found, expected) in [saved.gather_rays, saved.gather_rays_reused].into_iter().zip(expected) {
            assert!((found.unwrap() - expected).abs() <= 1e-9 * expected, "{found:?}, not {expected}");
        }
        // Four bounces take each ray's row once, but that elements that follow the light have the first one beforehand.
        assert!([3, 4].map(|times| times * report.gather_rays).contains(&report.gather_rays_reused), "{report:?}");
        assert!(line(&report, "gather rays again").ends_with("s of processor time"));
    }
}

#[test]
fn only_elements_that_follow_the_light_save_gathering_at_vertices() {
    let (even, following) = (report(even()), report(following()));
    assert_eq!((even.interpolated_vertices, even.seconds_saved.interpolated_vertices), (0, None));
    let by_vertex = following.gather_thread_seconds / following.gathered_vertices as f64;
    let expected = by_vertex * following.interpolated_vertices as f64;
    assert!((following.seconds_saved.interpolated_vertices.unwrap() / expected - 1.0).abs() < 1e-9 && expected > 0.0);
    assert!(following.direct_thread_seconds > 0.0);
}

#[test]
fn nothing_is_said_of_the_time_of_shadow_rays_where_none_was_traced() {
    for settings in [even(), following()] {
        let report = report(settings);
        assert!(report.shadow_rays == 0 && report.shadow_rays_skipped > 0, "a box of 30 triangles needs none");
        assert_eq!(report.seconds_saved.shadow_rays, None);
        assert!(!line(&report, "shadow rays").contains("processor time"));
    }
    let sampled = report(SolveSettings { direct: DirectMethod::Sampled, ..even() });
    let rays = sampled.shadow_rays_by_sight;
    assert!(rays.timed > 0 && rays.timed <= rays.traced && sampled.shadow_rays_skipped > 0);
    let expected = 1e-9 * rays.timed_nanoseconds as f64 / rays.timed as f64 * sampled.shadow_rays_skipped as f64;
    assert!((sampled.seconds_saved.shadow_rays.unwrap() / expected - 1.0).abs() < 1e-9);
    assert!(sampled.seconds_saved.shadow_rays.unwrap() < 60.0, "{sampled:?}");
}

#[test]
fn where_rows_are_traced_again_nothing_is_saved_and_tracing_takes_about_as_long_as_was_said() {
    let kept = report(even());
    let again = report(SolveSettings { row_memory: Some(0), ..even() });
    assert_eq!((again.gather_rays_reused, again.seconds_saved.gather_rays_reused), (0, Some(0.0)));
    assert!(!again.skipped().iter().any(|line| line.contains("gather rays again")));
    let took = again.gather_thread_seconds - kept.gather_thread_seconds;
    let said = kept.seconds_saved.gather_rays_reused.unwrap();
    // The same rays, but on a machine that may be busy in between.
    assert!(said > took / 5.0 && said < took * 5.0, "said {said} s, took {took} s");
}
