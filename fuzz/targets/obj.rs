//! Any text as an OBJ file: a sound scene that can be solved, or one line that says why not.
#![no_main]

#[path = "sound.rs"]
mod sound;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let text = String::from_utf8_lossy(bytes);
    sound::check_load(&text, "newmtl red\nKd 0.8 0.2 0.1\nnewmtl lamp\nKe 1 1 1\n");
});
