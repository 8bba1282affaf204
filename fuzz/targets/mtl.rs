//! Any text as an MTL file of two materials, one of them with texture coordinates.
#![no_main]

#[path = "sound.rs"]
mod sound;

const OBJ: &str = "mtllib any.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 1\nvt 0 0\nvt 1 0\nvt 1 1\nusemtl red\n\
    f 1/1 2/2 3/3\nusemtl lamp\nf 1 3 4\n";

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    sound::check_load(OBJ, &String::from_utf8_lossy(bytes));
});
