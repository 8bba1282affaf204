//! Any bytes as a solution file, on vertices or on a lightmap: refused, or a solution that is written to the same values.
#![no_main]

use radiosity::solver::{lightmap_solution, solution_file};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    match solution_file::decode(bytes) {
        Ok(solution) => {
            let vertices = solution.buried.len();
            for bounce in &solution.bounces {
                assert_eq!(bounce.len(), vertices);
                assert!(bounce.iter().all(|value| value.is_finite() && value.min_element() >= 0.0));
            }
            let written = solution_file::encode(&solution).expect("what was read can be written");
            assert_eq!(solution_file::decode(&written).expect("and read").bounces, solution.bounces);
        }
        Err(error) => assert_eq!(error.to_string().lines().count(), 1, "{error}"),
    }
    if lightmap_solution::is_lightmap(bytes) {
        match lightmap_solution::decode(bytes) {
            Ok(solution) => {
                let written = lightmap_solution::encode(&solution).expect("what was read can be written");
                assert!(lightmap_solution::decode(&written).is_ok());
            }
            Err(error) => assert_eq!(error.to_string().lines().count(), 1, "{error}"),
        }
    }
});
