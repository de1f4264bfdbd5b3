//! What is written and read is the same for any number of threads, and without the feature for them.

use fairform::{Faces, Vec3};
use fairform_io::{Format, Labels, MeshData, WriteOptions, encode, parse};

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
                    let data = parse(&bytes, format).unwrap();
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
