//! Any bytes read as glTF give a mesh or an error; a mesh can be written and reads back.
#![no_main]

use fairform_io::{Format, WriteOptions, encode, parse};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Ok(data) = parse(bytes, Format::Gltf) else { return };
    assert!(data.faces.corners().iter().all(|v| (*v as usize) < data.positions.len()));
    let mut out = Vec::new();
    if encode(Format::Gltf, &data, &WriteOptions::default(), &mut out).is_ok() {
        let again = parse(&out, Format::Gltf).expect("what we write, we read");
        assert!(again.faces.len() >= data.faces.iter().filter(|f| f.len() > 2).count());
    }
});
