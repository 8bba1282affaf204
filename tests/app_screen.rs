//! The window's screen-space view, beside the solution that judges it.
#![cfg(all(feature = "app", feature = "reference"))]
#![expect(clippy::unwrap_used, reason = "a failed unwrap fails the test")]

#[path = "common/window.rs"]
mod common;

use common::*;
use radiosity::{
    app::{App, command::Command, view_settings::Source},
    gpu::screen_space::ShownBuffer,
};

/// True once a view shows a mean of so many frames.
fn shows(app: &App, frames: u32) -> bool {
    app.screen.shown.as_ref().is_some_and(|shown| shown.still >= frames)
}

#[test]
fn the_screen_space_view_is_shown_beside_the_solution_and_judged_by_it() {
    let folder = tempfile::tempdir().unwrap();
    let Some(mut window) = window(folder.path()) else { return };
    {
        let app = window.state_mut();
        app.document.edit.settings.subdivide = 3;
        app.document.edit.settings.bounces = None;
        app.layout.second_view = true;
        app.layout.ambient = false;
        app.layout.views[1].shown = app.layout.views[0].shown;
        app.layout.views[1].source = Source::Screen;
        app.fulfil(Command::Solve);
    }
    run_until(&mut window, "the solution", |app| app.results.is_some() && !app.status().running);
    run_until(&mut window, "still frames", |app| shows(app, 9) && app.screen.shown.as_ref().unwrap().errors.is_some());
    let errors = window.state().screen.shown.as_ref().unwrap().errors.unwrap();
    assert!(errors.total > 0.0 && errors.total < 0.5, "{errors:?}");
    let lit = window.render().unwrap();
    // The back wall: much the same in both views.
    let [left, right] = [0.25, 0.75].map(|x| colour_at(&lit, &window, x, 0.4)[1]);
    assert!(right > 0.5 * left && right < 2.0 * left && left > 20.0, "{left} and {right}");
    // A buffer instead; then the camera moves, and frames begin anew.
    window.state_mut().screen.buffer = ShownBuffer::Depth;
    run_until(&mut window, "depth", |app| {
        app.screen.shown.as_ref().is_some_and(|shown| shown.buffer == ShownBuffer::Depth)
    });
    window.state_mut().camera.look(20.0, 0.0);
    let version = window.state().screen.shown.as_ref().unwrap().version;
    run_until(&mut window, "the new camera", |app| {
        let shown = app.screen.shown.as_ref().unwrap();
        shown.version > version && shown.still < 4
    });
    // Nothing is drawn for views that show something else.
    window.state_mut().layout.views[1].source = Source::Present;
    run_until(&mut window, "rest", |app| app.screen.job.is_none());
    // A view of what is not there says what it shows instead.
    window.state_mut().layout.views[1].source = Source::Lightmap;
    assert_eq!(window.state().view_title(1), window.state().view_title(0));
}
