//! Any bytes give a mesh or an error, soon, and without much memory for it.

use std::fs;
use std::sync::LazyLock;

use fairform_io::streamline::{self, Contents};
use fairform_io::{Format, MeshData, WriteOptions, encode, parse};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::{Index, select};
use serde_json::Value;

use crate::common::same_in_parts;

/// Small files of every format, good and bad, to make others from.
static SEEDS: LazyLock<Vec<(Format, Vec<u8>)>> = LazyLock::new(|| {
    let mut seeds = Vec::new();
    for folder in ["odd", "bad"] {
        for file in fs::read_dir(crate::common::meshes().join(folder)).unwrap() {
            let path = file.unwrap().path();
            let (format, _) = Format::from_path(&path).unwrap();
            let bytes = fs::read(&path).unwrap();
            if (1..3000).contains(&bytes.len()) {
                seeds.push((format, bytes));
            }
        }
    }
    seeds.sort_by(|a, b| a.1.cmp(&b.1));
    seeds
});

/// Small model files, of each fixture what was given.
static MODELS: LazyLock<Vec<Vec<u8>>> = LazyLock::new(|| {
    let golden = crate::common::data().join("golden");
    // All that the fixtures have not.
    let mut models = vec![include_bytes!("../all-fields.streamline.json").to_vec()];
    for folder in ["sphere", "streamline"] {
        for file in fs::read_dir(golden.join(folder)).unwrap() {
            let file: Value =
                serde_json::from_slice(&fs::read(file.unwrap().path()).unwrap()).unwrap();
            models.extend(file.get("spec").map(|spec| spec.to_string().into_bytes()));
        }
    }
    models.sort();
    models
});

/// Parses, and checks that what comes out is written, and reads back the same.
fn check_model(bytes: &[u8]) -> Result<(), TestCaseError> {
    let Ok(contents) = streamline::parse_any(bytes) else { return Ok(()) };
    let mut out = Vec::new();
    let written = match &contents {
        Contents::Surface(models) => streamline::encode(models, &mut out),
        Contents::Curve(curve) => streamline::encode_curve(curve, &mut out),
        _ => return Ok(()),
    };
    prop_assert!(written.is_ok());
    prop_assert_eq!(streamline::parse_any(&out), Ok(contents));
    Ok(())
}

/// What a mesh takes.
fn size(data: &MeshData) -> usize {
    let corners = data.faces.corners().len();
    24 * data.positions.len() + 4 * (data.faces.len() + corners)
}

/// Parses, and checks what readers promise of whatever comes out: the corners are vertices, the
/// size is in proportion to the bytes, and the writers take it.
/// In however many parts a text is read, the mesh or error is the same.
fn check(bytes: &[u8], format: Format) -> Result<(), TestCaseError> {
    same_in_parts(bytes, format)?;
    let Ok(data) = parse(bytes, format) else { return Ok(()) };
    prop_assert!(data.faces.corners().iter().all(|v| (*v as usize) < data.positions.len()));
    // glTF may repeat its parts; everything else says each number once, in at least 2 bytes.
    if !matches!(format, Format::Gltf | Format::Glb) {
        prop_assert!(size(&data) <= 16 * bytes.len(), "{} from {}", size(&data), bytes.len());
        for format in Format::ALL {
            let refused = encode(format, &data, &WriteOptions::default(), &mut Vec::new()).is_err();
            prop_assert!(!refused || matches!(format, Format::Gltf | Format::Glb));
        }
    }
    Ok(())
}

/// A change to some bytes.
#[derive(Clone, Debug)]
enum Change {
    Set(Index, u8),
    Insert(Index, Vec<u8>),
    Remove(Index, usize),
    Cut(Index),
    Repeat(Index, usize),
    /// A part of another file in place of its own.
    Splice(Index, Index, Index, usize),
}

impl Change {
    fn apply(&self, bytes: &mut Vec<u8>) {
        if bytes.is_empty() {
            return;
        }
        let n = bytes.len();
        match self {
            Self::Set(at, byte) => bytes[at.index(n)] = *byte,
            Self::Insert(at, new) => {
                let at = at.index(n);
                bytes.splice(at..at, new.iter().copied());
            }
            Self::Remove(at, count) => {
                let at = at.index(n);
                bytes.drain(at..(at + count).min(n));
            }
            Self::Cut(at) => bytes.truncate(at.index(n)),
            Self::Repeat(at, count) => {
                let at = at.index(n);
                let part = bytes[at..(at + count).min(n)].to_vec();
                bytes.splice(at..at, part);
            }
            Self::Splice(at, seed, from, count) => {
                let other = &SEEDS[seed.index(SEEDS.len())].1;
                let (at, from) = (at.index(n), from.index(other.len()));
                let part = &other[from..(from + count).min(other.len())];
                bytes.splice(at..(at + part.len()).min(n), part.iter().copied());
            }
        }
    }
}

fn change() -> impl Strategy<Value = Change> {
    let any_at = || any::<Index>();
    // What numbers, ends of lines and separators are made of, and extreme bytes.
    let telling = || {
        prop_oneof![
            select(&b"0123456789-+.eE#/\\\r\n \t\"[]{}:,nif\x00\xff\x7f\x80"[..]),
            any::<u8>()
        ]
    };
    prop_oneof![
        4 => (any_at(), telling()).prop_map(|(at, byte)| Change::Set(at, byte)),
        2 => (any_at(), vec(telling(), 1..9)).prop_map(|(at, new)| Change::Insert(at, new)),
        2 => (any_at(), 1..40_usize).prop_map(|(at, n)| Change::Remove(at, n)),
        1 => any_at().prop_map(Change::Cut),
        1 => (any_at(), 1..80_usize).prop_map(|(at, n)| Change::Repeat(at, n)),
        1 => (any_at(), any_at(), any_at(), 1..80_usize)
            .prop_map(|(at, seed, from, n)| Change::Splice(at, seed, from, n)),
    ]
}

/// What gets random bytes past the first look of a reader.
const STARTS: &[&[u8]] = &[
    b"",
    b"\x1f\x8b\x08",
    b"OFF\n",
    b"ply\nformat ascii 1.0\n",
    b"solid a\n",
    b"glTF\x02\0\0\0",
    b"v 1 2 3\nf ",
];

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(30_000) })]

    #[test]
    fn changed_files_give_a_mesh_or_an_error(seed in any::<Index>(), changes in vec(change(), 1..5)) {
        let (format, mut bytes) = SEEDS[seed.index(SEEDS.len())].clone();
        for change in &changes {
            change.apply(&mut bytes);
        }
        check(&bytes, format)?;
    }

    #[test]
    fn changed_models_give_models_or_an_error(seed in any::<Index>(), changes in vec(change(), 0..5)) {
        let mut bytes = MODELS[seed.index(MODELS.len())].clone();
        for change in &changes {
            change.apply(&mut bytes);
        }
        check_model(&bytes)?;
    }

    #[test]
    fn a_file_under_a_wrong_name_gives_a_mesh_or_an_error(seed in any::<Index>(), format in select(&Format::ALL[..])) {
        let bytes = &SEEDS[seed.index(SEEDS.len())].1;
        check(bytes, format)?;
        check_model(bytes)?;
    }

    #[test]
    fn any_bytes_give_a_mesh_or_an_error(
        format in select(&Format::ALL[..]),
        start in select(STARTS),
        bytes in vec(any::<u8>(), 0..300),
    ) {
        let mut all = start.to_vec();
        all.extend(bytes);
        check(&all, format)?;
        check_model(&all)?;
    }
}
