//! Any bytes read as STL give a mesh or an error; a mesh can be written and reads back.
#![no_main]

use fairform_fuzz::check_reader;
use fairform_io::Format;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| check_reader(bytes, Format::Stl));
