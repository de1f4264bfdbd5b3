//! What the targets for mesh files check.

use fairform_io::{Format, WriteOptions, encode, parse, parse_in_parts};

/// Any bytes read as a format give a mesh or an error, the same in however many parts they are read; a
/// mesh can be written and reads back.
///
/// # Panics
/// If that is not so.
pub fn check_reader(bytes: &[u8], format: Format) {
    let result = parse(bytes, format);
    if !bytes.starts_with(b"\x1f\x8b") {
        for parts in [3, bytes.len()] {
            let read = parse_in_parts(bytes, format, parts);
            // As text, NaN is NaN.
            if read != result {
                assert_eq!(format!("{read:?}"), format!("{result:?}"), "{parts} parts");
            }
        }
    }
    let Ok(data) = result else { return };
    assert!(data.faces.corners().iter().all(|v| (*v as usize) < data.positions.len()));
    let mut out = Vec::new();
    if encode(format, &data, &WriteOptions::default(), &mut out).is_ok() {
        let again = parse(&out, format).expect("what we write, we read");
        assert!(again.faces.len() >= data.faces.iter().filter(|f| f.len() > 2).count());
    }
}
