//! What is written and read is the same for any number of threads, and without the feature for them.

use fairform::{Faces, Vec3};
use fairform_io::{Format, Labels, MeshData, WriteOptions, encode};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::select;

use crate::common::same_in_parts;

/// Long enough for several blocks of rows and several parts of text.
fn torus() -> MeshData {
    let mesh = fairform::shapes::torus(130, 130);
    let positions = mesh.positions().to_vec();
    let triangles = mesh.topology().face_count();
    let labels = |size: usize| Labels {
        names: vec!["a".into(), "b c".into(), "d".into()],
        of_face: (0..triangles).map(|face| (face / size % 3) as u32).collect(),
    };
    let corners = mesh.topology().faces().flat_map(|f| {
        let at = mesh.topology().face_halfedges(f).map(|h| mesh.topology().origin(h).0);
        at.collect::<Vec<_>>()
    });
    let faces = Faces::uniform(3, corners.collect());
    MeshData {
        normals: Some(positions.iter().map(|p| p.normalized()).collect()),
        colours: Some(
            (0..positions.len()).map(|i| [(i % 256) as f64 / 255.0, 0.2, 0.4, 1.0]).collect(),
        ),
        corner_uvs: Some(
            (0..3 * triangles).map(|i| [(i % 1000) as f64 / 7.0, (i / 6) as f64]).collect(),
        ),
        groups: Some(labels(20_000)),
        materials: Some(labels(7)),
        positions,
        faces,
        ..MeshData::default()
    }
}

/// Faces of three sizes.
fn mixed() -> MeshData {
    let side = 135;
    let positions =
        (0..side * side).map(|i| Vec3::new(f64::from(i % side), f64::from(i / side), 0.1));
    let cells = (0..side - 1).flat_map(|i| (0..side - 1).map(move |j| i * side + j));
    let faces = cells.map(|v| match v % 3 {
        0 => vec![v, v + 1, v + side],
        1 => vec![v, v + 1, v + 1 + side, v + side],
        _ => vec![v, v + 1],
    });
    MeshData { positions: positions.collect(), faces: faces.collect(), ..MeshData::default() }
}

/// Every way to write.
fn all_ways(data: &MeshData) -> Vec<(Format, Vec<u8>)> {
    let mut all = Vec::new();
    for format in Format::ALL {
        for (ascii, single_precision) in [(false, true), (true, false)] {
            let mut bytes = Vec::new();
            let options = WriteOptions { ascii, single_precision };
            encode(format, data, &options, &mut bytes).unwrap();
            all.push((format, bytes));
        }
    }
    all
}

#[cfg(feature = "parallel")]
#[test]
fn threads_change_nothing() {
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let meshes = [torus(), mixed()];
            let written = meshes.iter().flat_map(all_ways);
            written
                .map(|(format, bytes)| {
                    let data = fairform_io::parse(&bytes, format).unwrap();
                    (format, bytes, data)
                })
                .collect::<Vec<_>>()
        })
    };
    let one = on(1);
    for (expected, (format, bytes, data)) in one.iter().zip(on(3)) {
        assert!(expected.1 == bytes, "{format} written");
        assert!(expected.2 == data, "{format} read");
    }
}

/// The FNV-1a hash of the bytes, which no number of threads and no feature changes.
#[test]
fn the_bytes_are_those_written_before() {
    let hash = |bytes: &[u8]| {
        bytes.iter().fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
            (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3)
        })
    };
    let hashes = |data: &MeshData| {
        all_ways(data)
            .iter()
            .map(|(_, bytes)| hash(bytes))
            .fold(0, |all: u64, hash| all.rotate_left(5) ^ hash)
    };
    assert_eq!(
        [hashes(&torus()), hashes(&mixed())],
        [18_184_485_209_823_642_268, 765_771_506_035_344_139]
    );
}

/// One of the lines: mostly of the first so many, which are as they should be.
fn line(good: usize, lines: &'static [&'static str]) -> BoxedStrategy<&'static str> {
    prop_oneof![60 => select(&lines[..good]), 1 => select(lines)].boxed()
}

/// Lines, some with nothing before each, and their ends.
fn text(lines: Vec<BoxedStrategy<&'static str>>) -> impl Strategy<Value = String> {
    let between = select(
        &[
            "", "", "", "", "", "", "", "", "", "", "", "", "", "", "\n", " \n", "\r\n", " ", "\t",
            "# x\n",
        ][..],
    );
    let ends = select(&["\n", "\r\n", " \n", "\n", "\n", "\n", "\r"][..]);
    let n = lines.len();
    // Mostly without comments, which only OFF has.
    (lines, vec(between, n), vec(ends, n), any::<u8>()).prop_map(|(lines, between, ends, kind)| {
        let mut text = String::new();
        for ((line, between), end) in lines.iter().zip(between).zip(ends) {
            text += if kind % 4 == 0 || !between.contains('#') { between } else { "" };
            text += line;
            text += if kind % 2 == 0 { end } else { "\n" };
        }
        if kind % 8 > 5 {
            text.pop();
        }
        text
    })
}

/// OFF files of a few layouts, most of them good.
fn off() -> impl Strategy<Value = String> {
    let header = select(
        &[
            ("OFF", "0 1 2.5"),
            ("COFF", "0 1 2 255 0 7"),
            ("COFF", "0 1 2 0.5 0 1 0.1"),
            ("NOFF", "1e3 0 0 0 0 1"),
            ("STCNOFF", "0 1 2 0 0 1 9 9 9 1 0.5 0.5"),
        ][..],
    );
    let faces: &[_] =
        &["3 0 1 2", "0", "4 0 1 2 3", "3 2 1 0 255 0 0", "3 0 1", "3 0\n1 2", "3 0 1 99", "x", ""];
    (header, 4..30_usize, 0..30_usize, -1..9_i32).prop_flat_map(move |((kind, row), v, f, more)| {
        let declared = if more < 0 { f + 1 } else { f };
        let mut lines = vec![Just(kind).boxed()];
        let vertex = prop_oneof![
            40 => Just(row),
            1 => select(&["0 1 2", "0 1\n2", "0 1 2 3 4 5 6 7 8 9 10 11 12 13", "0 x 1", "nan 0 0"][..])
        ];
        lines.extend((0..v).map(|_| vertex.clone().boxed()));
        lines.extend((0..f).map(|_| line(4, faces)));
        lines.extend((more == 3).then(|| Just("more\nof it\n\nand of that").boxed()));
        text(lines).prop_map(move |text| text.replacen(kind, &format!("{kind}\n{v} {declared} 0"), 1))
    })
}

/// PLY files of a few elements in some order, most of them good.
fn ply() -> impl Strategy<Value = String> {
    type Element = (&'static str, &'static [&'static str], usize, &'static [&'static str]);
    const ELEMENTS: [Element; 7] = [
        (
            "vertex",
            &["float x", "float y", "float z"],
            2,
            &["0 1 2.5", "-1e2 0 0", "0 1", "0 1\n2", "0 1 2 3", "x"],
        ),
        (
            "vertex",
            &[
                "double z",
                "float x",
                "list uchar int l",
                "uchar red",
                "uchar green",
                "uchar blue",
                "float y",
                "float nx",
                "float ny",
                "float nz",
                "float u",
                "float v",
            ],
            2,
            &[
                "0 1 0 255 0 0 2 0 0 1 0 0",
                "0 1 2 7 8 0 9 0 2.5 1 0 0 1 .5",
                "0 1 3 7 8",
                "0\n1 0 9 9 9 2 0 0 1 0 0",
            ],
        ),
        (
            "face",
            &["list uchar int vertex_indices"],
            3,
            &["3 0 1 2", "4 0 1 2 3", "0", "3 0 1", "3 0 1 99", "3 0\n1 2"],
        ),
        (
            "face",
            &["uchar flags", "list uchar int vertex_index", "list uchar float texcoord"],
            3,
            &[
                "0 3 0 1 2 6 0 0 1 0 .5 1",
                "1 3 2 1 0 0",
                "0 0 0",
                "0 3 0 1 2",
                "0 3 0 1 2 -1",
                "0\n3 0 1 2 0",
            ],
        ),
        (
            "tristrips",
            &["list int int vertex_indices"],
            3,
            &["5 0 1 2 3 1", "7 0 1 2 -1 1 2 3", "0", "3 0 1 x"],
        ),
        ("edge", &["int a", "list uchar short b"], 2, &["0 0", "word 2 any words", "0", "0 2 1"]),
        ("empty", &[], 1, &[""]),
    ];
    let chosen = vec((0..5_usize, 3..20_usize), 0..4);
    (0..2_usize, 5..40_usize, chosen, -1..9_i32, any::<bool>()).prop_flat_map(
        |(vertex, v, others, more, last)| {
            let mut elements = vec![(vertex, v)];
            elements.extend(others.iter().map(|(other, count)| (2 + other, *count)));
            let mut names: Vec<_> = Vec::new();
            elements.retain(|(e, _)| {
                !names.contains(&ELEMENTS[*e].0) && {
                    names.push(ELEMENTS[*e].0);
                    true
                }
            });
            if last {
                elements.reverse();
            }
            let mut header = "ply\nformat ascii 1.0\n".to_string();
            let mut lines = Vec::new();
            for (i, &(element, count)) in elements.iter().enumerate() {
                let (name, properties, good, rows) = ELEMENTS[element];
                let cut = usize::from(more < 0 && i + 1 == elements.len());
                header += &format!("element {name} {}\n", count + cut);
                properties.iter().for_each(|p| header += &format!("property {p}\n"));
                if !properties.is_empty() {
                    lines.extend((0..count).map(|_| line(good, rows)));
                }
            }
            lines.extend((more == 3).then(|| Just("more\nof it\n\nand of that").boxed()));
            text(lines).prop_map(move |text| format!("{header}end_header\n{text}"))
        },
    )
}

/// STL texts of solids with facets that stand in lines in several ways, most of them good.
fn stl() -> impl Strategy<Value = String> {
    let facets: &[_] = &[
        "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet",
        " FACET NORMAL 0 0 1\r\nOUTER LOOP\r\nVERTEX 1 0 0\r\nVERTEX 1 1 0\r\nVERTEX 0 1 0\r\nENDLOOP\r\nENDFACET",
        "facet outer loop vertex 0 0 0 vertex 1 1 1 vertex 2 2 2 endloop endfacet",
        "facet\nfacet\n1\nouter\nloop\nvertex\n0\n0\n2 vertex 1 0 2 vertex 0 1 2\nendloop\nendfacet",
        "facet normal 0 0 1\nouter loop\nvertex 5 0 0\nvertex 5 0 0\nvertex 0 5 0\nendloop\nendfacet",
        "endsolid\nsolid facet",
        "endsolid a\nsolid b\nendsolid b\nsolid a",
        "endsolid\rsolid c d",
        "endsolid",
        "solid",
        "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nendloop\nendfacet",
        "facet normal 0 0 1\nouter loop\nvertex 0 0 x\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet",
        "facet normal 0 0 1",
        "endfacet",
    ];
    (0..40_usize)
        .prop_map(move |n| (0..n).map(|_| line(8, facets)).collect::<Vec<_>>())
        .prop_flat_map(|mut lines| {
            lines.insert(0, Just("solid a").boxed());
            lines.push(prop_oneof![9 => Just("endsolid a"), 1 => Just("# x")].boxed());
            text(lines)
        })
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(600) })]

    #[test]
    fn an_off_file_in_parts_is_the_same(text in off()) {
        same_in_parts(text.as_bytes(), Format::Off)?;
    }

    #[test]
    fn a_ply_file_in_parts_is_the_same(text in ply()) {
        same_in_parts(text.as_bytes(), Format::Ply)?;
    }

    #[test]
    fn an_stl_file_in_parts_is_the_same(text in stl()) {
        same_in_parts(text.as_bytes(), Format::Stl)?;
    }
}
