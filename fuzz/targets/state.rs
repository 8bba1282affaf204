//! Any text as a state file: what is read can be written, and is then read as the same.
#![no_main]

use radiosity::solver::State;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    match State::from_toml(&String::from_utf8_lossy(bytes)) {
        Ok((state, warnings)) => {
            assert!(warnings.iter().all(|warning| warning.lines().count() == 1), "{warnings:?}");
            let written = state.to_toml().expect("a state that was read can be written");
            let (again, _) = State::from_toml(&written).expect("a state that was written can be read");
            assert_eq!(again.to_toml().as_ref(), Ok(&written));
        }
        Err(line) => assert!(!line.trim().is_empty()),
    }
});
