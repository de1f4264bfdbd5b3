//! What is written reads back as the same bits, as far as the format can hold it.

use std::fs;
use std::io::{self, Write};
use std::path::Path;

use fairform::{Faces, Vec3};
use fairform_io::{
    CreaseList, Error, Format, InterpolateBoundary, Labels, MeshData, WriteOptions, encode, parse,
    read, save, write,
};

fn options(ascii: bool) -> WriteOptions {
    WriteOptions { ascii, ..WriteOptions::default() }
}

/// Encodes and parses again: the mesh without its reader's notes, and the writer's notes.
fn there_and_back(data: &MeshData, format: Format, ascii: bool) -> (MeshData, Vec<String>) {
    let mut bytes = Vec::new();
    let notes = encode(format, data, &options(ascii), &mut bytes).unwrap();
    let mut again = Vec::new();
    encode(format, data, &options(ascii), &mut again).unwrap();
    assert_eq!(bytes, again, "the same data give the same bytes");
    let mut back = parse(&bytes, format).unwrap_or_else(|e| panic!("{format}: {e}"));
    back.notes.clear();
    (back, notes)
}

fn points(coordinates: &[[f64; 3]]) -> Vec<Vec3> {
    coordinates.iter().map(|p| (*p).into()).collect()
}

fn faces(faces: &[&[u32]]) -> Faces {
    faces.iter().collect()
}

/// A cube of quads with coordinates that are short neither in decimal nor in 32 bits.
fn cube() -> MeshData {
    let corner = |i: u32| {
        let side = |bit: u32| if i >> bit & 1 == 1 { 1.0 / 3.0 } else { -0.1 };
        Vec3::new(side(0), side(1), 1e-9 * side(2))
    };
    MeshData {
        positions: (0..8).map(corner).collect(),
        faces: faces(&[
            &[0, 2, 3, 1],
            &[4, 5, 7, 6],
            &[0, 1, 5, 4],
            &[2, 6, 7, 3],
            &[0, 4, 6, 2],
            &[1, 3, 7, 5],
        ]),
        ..MeshData::default()
    }
}

/// Faces of 0 to 9 corners, one vertex twice in a face, vertices of no face.
fn mixed() -> MeshData {
    let positions = (0..12).map(f64::from).map(|t| Vec3::new(t, t * t, (t * 0.7).sin())).collect();
    let faces = faces(&[
        &[1, 2, 3],
        &[4, 3, 2, 1],
        &[1, 2, 3, 4, 5],
        &[9, 8, 7, 6, 5, 4, 3, 2, 1],
        &[7, 8, 7, 9],
        &[5, 6],
        &[5],
        &[],
        &[9, 10, 5],
    ]);
    MeshData { positions, faces, ..MeshData::default() }
}

fn awkward_numbers() -> MeshData {
    let positions = points(&[
        [f64::MAX, f64::MIN_POSITIVE, 5e-324],
        [-0.0, f64::INFINITY, f64::NEG_INFINITY],
        [0.1 + 0.2, 1e22, 123_456_789.123_456_79],
    ]);
    MeshData { positions, faces: faces(&[&[0, 1, 2]]), ..MeshData::default() }
}

fn bytes_of(i: usize) -> [f64; 4] {
    [i * 31 % 256, i * 7 % 256, 255 - i, 255].map(|b| b as f64 / 255.0)
}

fn shapes() -> Vec<(&'static str, MeshData)> {
    let empty = MeshData::default();
    let cloud = MeshData { positions: cube().positions, ..MeshData::default() };
    let wide = MeshData {
        positions: (0..300)
            .map(|i| Vec3::new((f64::from(i)).cos(), (f64::from(i)).sin(), 0.0))
            .collect(),
        faces: faces(&[&(0..300).collect::<Vec<u32>>(), &[0, 1, 2]]),
        ..MeshData::default()
    };
    let byte_colours = MeshData { colours: Some((0..8).map(bytes_of).collect()), ..cube() };
    let dark = MeshData { colours: Some(vec![[0.0, 1.0 / 255.0, 0.0, 1.0 / 255.0]; 8]), ..cube() };
    let real_colours = MeshData {
        colours: Some((0..8).map(|i| [f64::from(i) / 9.0, 0.5, 1.0, 0.25]).collect()),
        ..cube()
    };
    let normals = MeshData {
        normals: Some(cube().positions.iter().map(|p| p.normalized()).collect()),
        ..cube()
    };
    let uvs =
        MeshData { uvs: Some((0..12).map(|i| [f64::from(i) / 7.0, 0.3]).collect()), ..mixed() };
    let all = MeshData {
        normals: normals.normals.clone(),
        colours: byte_colours.colours.clone(),
        uvs: Some((0..8).map(|i| [f64::from(i) / 7.0, -0.3]).collect()),
        ..cube()
    };
    vec![
        ("empty", empty),
        ("cloud", cloud),
        ("cube", cube()),
        ("mixed", mixed()),
        ("awkward numbers", awkward_numbers()),
        ("wide", wide),
        ("byte colours", byte_colours),
        ("dark", dark),
        ("real colours", real_colours),
        ("normals", normals),
        ("uvs", uvs),
        ("all", all),
    ]
}

/// The bits, since `PartialEq` takes 0 for −0.
fn bits(points: &[Vec3]) -> Vec<[u64; 3]> {
    points.iter().map(|p| [p.x, p.y, p.z].map(f64::to_bits)).collect()
}

#[test]
fn obj_off_and_ply_keep_every_bit() {
    for (name, data) in shapes() {
        for (format, ascii) in
            [(Format::Obj, true), (Format::Off, true), (Format::Ply, true), (Format::Ply, false)]
        {
            let (back, notes) = there_and_back(&data, format, ascii);
            assert_eq!(back, data, "{name} as {format}");
            assert_eq!(bits(&back.positions), bits(&data.positions), "{name} as {format}");
            let alpha = data.colours.iter().flatten().any(|c| c[3] < 1.0);
            assert_eq!(
                notes.is_empty(),
                !(alpha && format == Format::Obj),
                "{name} {format} {notes:?}"
            );
        }
    }
}

/// A cube unfolded: the corners of a vertex have different texture coordinates.
fn seamed() -> MeshData {
    let uv = |i: usize| [(i % 4) as f64 / 3.0, (i / 4 % 3) as f64];
    MeshData { corner_uvs: Some((0..24).map(uv).collect()), ..cube() }
}

/// Sharp edges are tags of OBJ, and normals on either side of them its `vn` per corner.
#[test]
fn only_obj_keeps_creases_and_their_normals() {
    let data = MeshData {
        normals: Some(vec![Vec3::new(0.0, 0.0, 1.0); 8]),
        corner_normals: Some((0..24).map(|i| Vec3::new(f64::from(i / 4), 1.0, 0.0)).collect()),
        creases: Some(CreaseList {
            edges: vec![([0, 1], 2.5), ([3, 1], 10.0)],
            vertices: vec![(7, 1.0 / 3.0)],
            holes: vec![4],
            boundary: Some(InterpolateBoundary::None),
        }),
        ..cube()
    };
    let (back, notes) = there_and_back(&data, Format::Obj, true);
    // The mean follows from the normals of the corners.
    assert_eq!(back, MeshData { normals: None, ..data.clone() });
    assert!(notes.is_empty(), "{notes:?}");
    for format in [Format::Off, Format::Ply, Format::Glb, Format::Gltf, Format::Stl] {
        let (back, notes) = there_and_back(&data, format, false);
        let notes = notes.join("\n");
        assert!(notes.contains("crease tags"), "{format}: {notes}");
        assert!(notes.contains("normals of"), "{format}: {notes}");
        assert_eq!((back.creases, back.corner_normals), (None, None));
    }
}

fn labelled() -> MeshData {
    let labels = |names: &[&str], of_face: &[u32]| {
        let names = names.iter().map(ToString::to_string).collect();
        Some(Labels { names, of_face: of_face.to_vec() })
    };
    MeshData {
        groups: labels(&["top side", "größe", "c"], &[0, 1, 1, 0, 2, 2]),
        materials: labels(&["", "red", "blue#2"], &[0, 0, 1, 1, 2, 1]),
        material_library: Some("a.mtl\nb c.mtl".into()),
        ..cube()
    }
}

#[test]
fn seams_stay_in_obj_and_ply() {
    for (format, ascii) in [(Format::Obj, true), (Format::Ply, true), (Format::Ply, false)] {
        let (back, notes) = there_and_back(&seamed(), format, ascii);
        assert_eq!((back, notes), (seamed(), vec![]), "{format}");
    }
    for format in [Format::Off, Format::Stl, Format::Glb] {
        let (_, notes) = there_and_back(&seamed(), format, false);
        assert!(notes.iter().any(|n| n.contains("texture coordinates")), "{format}: {notes:?}");
    }
}

#[test]
fn groups_and_materials_stay_in_obj() {
    let (back, notes) = there_and_back(&labelled(), Format::Obj, true);
    assert_eq!((back, notes), (labelled(), vec![]));
    for (format, ascii) in [(Format::Off, true), (Format::Ply, false), (Format::Stl, false)] {
        let (_, notes) = there_and_back(&labelled(), format, ascii);
        let lost = notes.iter().find(|n| n.contains("groups")).expect("a note");
        assert!(lost.contains("materials") && lost.contains("library"), "{format}: {lost}");
    }
    // A text STL has a solid for each run of a group.
    let (back, _) = there_and_back(&labelled(), Format::Stl, true);
    let groups = back.groups.unwrap();
    assert_eq!(groups.names, ["top side", "größe", "c"]);
    assert_eq!(groups.of_face, [0, 0, 1, 1, 1, 1, 0, 0, 2, 2, 2, 2]);
}

#[test]
fn names_cannot_break_out_of_their_statement() {
    let name = "a\nf 9 9 9 #b\\".to_string();
    let data = MeshData {
        groups: Some(Labels { names: vec![name], of_face: vec![0; 6] }),
        material_library: Some("# c\\".into()),
        ..cube()
    };
    let (back, _) = there_and_back(&data, Format::Obj, true);
    assert_eq!(back.faces, data.faces);
    assert_eq!(back.groups.unwrap().names, ["a f 9 9 9 _b_"]);
}

/// In glTF and STL everything becomes triangles of the same area in 32 bits.
#[test]
fn gltf_and_stl_hold_triangles_in_32_bits() {
    let data = MeshData {
        normals: Some(vec![Vec3::new(0.0, 0.6, -0.8); 8]),
        colours: Some((0..8).map(bytes_of).collect()),
        uvs: Some((0..8).map(|i| [f64::from(i) / 8.0, 0.5]).collect()),
        materials: labelled().materials,
        ..cube()
    };
    let round = |x: f64| f64::from(x as f32);
    let rounded = |p: &Vec3| Vec3::new(round(p.x), round(p.y), round(p.z));
    for format in [Format::Gltf, Format::Glb] {
        let (back, notes) = there_and_back(&data, format, false);
        assert_eq!(back.positions, data.positions.iter().map(rounded).collect::<Vec<_>>());
        assert_eq!(back.faces.uniform_size(), Some(3));
        assert_eq!(back.faces.len(), 12);
        assert_eq!(back.colours, data.colours, "bytes stay bytes");
        assert_eq!(back.uvs, data.uvs);
        assert_eq!(
            back.normals.unwrap(),
            data.normals.clone().unwrap().iter().map(rounded).collect::<Vec<_>>()
        );
        assert_eq!(back.materials.unwrap().of_face, [0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 2, 2]);
        assert!(notes.iter().any(|n| n == "6 polygons cut into triangles"), "{notes:?}");
        assert!(notes.iter().any(|n| n.contains("rounded")), "{notes:?}");
    }
    for ascii in [true, false] {
        let (back, notes) = there_and_back(&cube(), Format::Stl, ascii);
        assert_eq!((back.positions.len(), back.faces.len()), (8, 12), "welded again");
        assert_eq!(notes.iter().any(|n| n.contains("rounded")), !ascii, "{notes:?}");
    }
    for (name, data) in shapes().into_iter().filter(|(name, _)| !name.contains("awkward")) {
        for format in [Format::Gltf, Format::Glb, Format::Stl] {
            let (back, _) = there_and_back(&data, format, true);
            let triangles: usize = data.faces.iter().map(|f| f.len().saturating_sub(2)).sum();
            assert_eq!(back.faces.len(), triangles, "{name} as {format}");
        }
    }
}

#[test]
fn what_cannot_be_written_is_refused() {
    let refused = |data: &MeshData, format| {
        encode(format, data, &WriteOptions::default(), &mut Vec::new()).unwrap_err().to_string()
    };
    let message = refused(&awkward_numbers(), Format::Glb);
    assert!(message.contains("finite") && message.contains("vertex 0"), "{message}");
    let bad = MeshData { faces: faces(&[&[0, 1, 8]]), ..cube() };
    let message = refused(&bad, Format::Obj);
    assert!(message.ends_with("face 0 lists vertex 8, but the mesh has 8 vertices"), "{message}");
    let short = MeshData { uvs: Some(vec![[0.0; 2]; 3]), ..cube() };
    assert!(refused(&short, Format::Ply).ends_with("3 uvs, expected 8"));
}

#[test]
fn single_precision_takes_half_the_room() {
    let write = |single_precision| {
        let mut bytes = Vec::new();
        let options = WriteOptions { single_precision, ascii: false };
        encode(Format::Ply, &cube(), &options, &mut bytes).unwrap();
        bytes
    };
    let (double, single) = (write(false), write(true));
    // Three words become "float" instead of "double", and 24 numbers lose 4 bytes each.
    assert_eq!(double.len() - single.len(), 3 + 24 * 4);
    let back = parse(&single, Format::Ply).unwrap();
    let third = f64::from(1.0_f32 / 3.0);
    assert_eq!(back.positions[7], Vec3::new(third, third, f64::from((1e-9 / 3.0) as f32)));
}

/// Every file that reads also writes, and reads back with the same faces.
#[test]
fn real_meshes_go_round() {
    for name in ["quad/spot_control.obj", "polygon/platonic_shelf_be.ply", "quad/suzanne.obj"] {
        let data = read(&crate::common::meshes().join(name), None).unwrap();
        for format in [Format::Obj, Format::Off, Format::Ply] {
            let (back, _) = there_and_back(&data, format, false);
            assert_eq!((back.positions, back.faces), (data.positions.clone(), data.faces.clone()));
        }
        let (back, _) = there_and_back(&data, Format::Obj, false);
        assert_eq!(back, MeshData { notes: vec![], ..data });
    }
}

fn entries(folder: &Path) -> Vec<String> {
    let name = |e: io::Result<fs::DirEntry>| e.unwrap().file_name().into_string().unwrap();
    let mut names: Vec<_> = fs::read_dir(folder).unwrap().map(name).collect();
    names.sort();
    names
}

#[test]
fn files_go_round_gzipped_too() {
    let folder = tempfile::tempdir().unwrap();
    for format in Format::ALL {
        for gzip in ["", ".gz", ".GZ"] {
            let path = folder.path().join(format!("mesh.{format}{gzip}"));
            assert_eq!(Format::from_path(&path), Some((format, !gzip.is_empty())));
            write(&path, None, &cube(), &WriteOptions::default()).unwrap();
            let packed = fs::read(&path).unwrap().starts_with(&[0x1f, 0x8b]);
            assert_eq!(packed, !gzip.is_empty());
            assert_eq!(read(&path, None).unwrap().positions.len(), 8, "{}", path.display());
        }
    }
    assert_eq!(entries(folder.path()).len(), 18, "nothing else is left");
}

#[test]
fn a_gzip_bomb_is_refused() {
    let mut packer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
    let zeros = vec![0; 1 << 20];
    for _ in 0..100 {
        packer.write_all(&zeros).unwrap();
    }
    let bomb = packer.finish().unwrap();
    assert!(bomb.len() < 200_000);
    let message = parse(&bomb, Format::Obj).unwrap_err().to_string();
    assert!(message.starts_with("the gzip data unpack to more than"), "{message}");
    let message = parse(&bomb[..bomb.len() / 2], Format::Obj).unwrap_err().to_string();
    assert!(message.starts_with("the gzip data are damaged"), "{message}");
}

#[test]
fn a_file_is_saved_whole_or_not_at_all() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.txt");
    save(&path, &mut |out| out.write_all(b"old")).unwrap();
    let error = save(&path, &mut |out| {
        out.write_all(b"half of the new")?;
        Err(io::Error::other("the disk is full"))
    });
    assert!(matches!(error, Err(Error::Write { .. })));
    assert_eq!(fs::read(&path).unwrap(), b"old");
    // Coordinates that glTF cannot hold must not cost the file that was there.
    let mesh = folder.path().join("a.glb");
    write(&mesh, None, &cube(), &WriteOptions::default()).unwrap();
    let before = fs::read(&mesh).unwrap();
    write(&mesh, None, &awkward_numbers(), &WriteOptions::default()).unwrap_err();
    assert_eq!(fs::read(&mesh).unwrap(), before);
    assert_eq!(entries(folder.path()), ["a.glb", "a.txt"]);
}

#[test]
fn what_a_signal_interrupts_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.txt");
    let result = save(&path, &mut |out| {
        out.write_all(b"something")?;
        assert_eq!(entries(folder.path()).len(), 1, "the temporary file");
        fairform_io::discard_pending();
        assert_eq!(entries(folder.path()).len(), 0);
        Ok(())
    });
    result.unwrap_err();
    assert_eq!(entries(folder.path()).len(), 0);
}

#[cfg(unix)]
#[test]
fn permissions_and_links_stay() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let folder = tempfile::tempdir().unwrap();
    let (file, link) = (folder.path().join("file"), folder.path().join("link"));
    fs::write(&file, "old").unwrap();
    fs::set_permissions(&file, fs::Permissions::from_mode(0o640)).unwrap();
    symlink("file", &link).unwrap();
    save(&link, &mut |out| out.write_all(b"new")).unwrap();
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    assert_eq!(fs::read(&file).unwrap(), b"new");
    assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o640);
    // Not the owner's alone, as temporary files are, but as any new file.
    let (plain, saved) = (folder.path().join("plain"), folder.path().join("saved"));
    fs::write(&plain, "").unwrap();
    save(&saved, &mut |_| Ok(())).unwrap();
    let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode();
    assert_eq!(mode(&saved), mode(&plain));
    save(Path::new("/dev/null"), &mut |out| out.write_all(b"gone")).unwrap();
    assert!(!fs::metadata("/dev/null").unwrap().is_file());
}

/// A buffer beside the file is read; one that a link takes elsewhere is not.
#[cfg(unix)]
#[test]
fn buffers_are_read_from_the_folder_only() {
    use std::os::unix::fs::symlink;
    let folder = tempfile::tempdir().unwrap();
    let inside = folder.path().join("inside");
    fs::create_dir(&inside).unwrap();
    let mut glb = Vec::new();
    encode(Format::Glb, &cube(), &WriteOptions::default(), &mut glb).unwrap();
    let json_length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    let json = std::str::from_utf8(&glb[20..20 + json_length]).unwrap();
    let buffer = &glb[28 + json_length..];
    let with = |name: &str| {
        let json = json
            .replace("\"byteLength\":240}]", &format!("\"byteLength\":240,\"uri\":\"{name}\"}}]"));
        assert!(json.contains("uri"), "{json}");
        fs::write(inside.join("mesh.gltf"), json).unwrap();
        read(&inside.join("mesh.gltf"), None)
    };
    fs::write(inside.join("a b.bin"), buffer).unwrap();
    fs::write(folder.path().join("outside.bin"), buffer).unwrap();
    symlink("../outside.bin", inside.join("link.bin")).unwrap();
    assert_eq!(with("a%20b.bin").unwrap().faces.len(), 12);
    assert_eq!(with("./a b.bin").unwrap().faces.len(), 12);
    let outside = folder.path().join("outside.bin").display().to_string();
    for name in [
        "../outside.bin",
        "%2e%2e/outside.bin",
        "link.bin",
        &outside,
        "http://a/b.bin",
        "file:///b",
    ] {
        let message = with(name).unwrap_err().to_string();
        assert!(message.contains("outside the folder"), "{message}");
    }
}
