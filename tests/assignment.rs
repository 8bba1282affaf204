//! One test a task of the assignment: it passes once the task is done.

use radiosity::{
    check::tasks::{Status, TASKS, run_task, task},
    cli::check::table,
    student::FUNCTIONS,
};

fn assert_done(name: &str) {
    let task = task(name).unwrap_or_else(|| panic!("there is no task {name}"));
    let report = run_task(task, &FUNCTIONS, 1);
    assert!(report.status == Status::Done, "\n{}", table(&[report]));
}

macro_rules! tasks {
    ($($name:ident)*) => {
        $(#[test]
        fn $name() {
            assert_done(stringify!($name));
        })*

        #[test]
        fn every_task_has_its_test() {
            assert_eq!(TASKS.map(|task| task.name), [$(stringify!($name)),*]);
        }
    };
}

tasks!(basis disk hemisphere barycentric light unshadowed shadows bounce bounces textures concentric stratified qmc);
