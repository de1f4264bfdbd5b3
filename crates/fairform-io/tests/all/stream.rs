//! What is written block by block is what is written at once, byte for byte.

use std::ops::Range;

use fairform::{Faces, Vec3};
use fairform_io::{
    Attributes, Blocks, Error, Format, Labels, MeshData, Patch, Shape, WriteOptions, can_stream,
    encode, encode_blocks,
};

/// A mesh in memory, cut into blocks of so many vertices or faces.
struct Cut {
    data: MeshData,
    size: usize,
}

impl Cut {
    fn range(&self, block: usize, len: usize) -> Range<usize> {
        block * self.size..((block + 1) * self.size).min(len)
    }

    fn faces_of(&self, block: usize) -> Range<usize> {
        self.range(block, self.data.faces.len())
    }
}

fn part<T: Clone>(values: Option<&Vec<T>>, wanted: bool, range: &Range<usize>) -> Option<Vec<T>> {
    values.filter(|_| wanted).map(|values| values[range.clone()].to_vec())
}

fn names(labels: Option<&Labels>) -> Option<&[String]> {
    labels.map(|labels| labels.names.as_slice())
}

impl Blocks for Cut {
    fn shape(&self) -> Shape<'_> {
        let data = &self.data;
        let mut used = vec![false; data.positions.len()];
        data.faces.corners().iter().for_each(|&v| used[v as usize] = true);
        Shape {
            vertex_count: data.positions.len(),
            face_count: data.faces.len(),
            face_size: data.faces.uniform_size().unwrap_or(3) as usize,
            normals: data.normals.is_some(),
            colours: data.colours.is_some(),
            uvs: data.uvs.is_some(),
            corner_uvs: data.corner_uvs.is_some(),
            groups: names(data.groups.as_ref()),
            materials: names(data.materials.as_ref()),
            material_library: data.material_library.as_deref(),
            unused: used.iter().filter(|used| !**used).count(),
            ..Shape::default()
        }
    }

    fn vertex_block_count(&self) -> usize {
        self.data.positions.len().div_ceil(self.size)
    }

    fn vertices(&self, block: usize, wanted: Attributes) -> MeshData {
        let (data, range) = (&self.data, self.range(block, self.data.positions.len()));
        let positions =
            if wanted.positions { data.positions[range.clone()].to_vec() } else { vec![] };
        MeshData {
            positions,
            normals: part(data.normals.as_ref(), wanted.normals, &range),
            colours: part(data.colours.as_ref(), wanted.colours, &range),
            uvs: part(data.uvs.as_ref(), wanted.uvs, &range),
            ..MeshData::default()
        }
    }

    fn face_block_count(&self) -> usize {
        self.data.faces.len().div_ceil(self.size)
    }

    fn faces(&self, block: usize) -> MeshData {
        let (data, range) = (&self.data, self.faces_of(block));
        let size = data.faces.uniform_size().unwrap_or(3) as usize;
        let corners = size * range.start..size * range.end;
        let labels = |labels: &Option<Labels>| {
            let of_face = labels.as_ref()?.of_face[range.clone()].to_vec();
            Some(Labels { names: vec![], of_face })
        };
        MeshData {
            faces: Faces::uniform(size as u32, data.faces.corners()[corners.clone()].to_vec()),
            corner_uvs: part(data.corner_uvs.as_ref(), true, &corners),
            groups: labels(&data.groups),
            materials: labels(&data.materials),
            ..MeshData::default()
        }
    }

    fn labels_before(&self, block: usize) -> [Option<u32>; 2] {
        let last = self.faces_of(block).start.checked_sub(1);
        [&self.data.groups, &self.data.materials]
            .map(|labels| Some(labels.as_ref()?.of_face[last?]))
    }

    fn patch(&self, block: usize) -> Patch {
        let faces = self.faces(block).faces;
        let numbers = faces.corners().to_vec();
        Patch {
            positions: numbers.iter().map(|&v| self.data.positions[v as usize]).collect(),
            faces: Faces::uniform(
                faces.uniform_size().unwrap_or(3),
                (0..numbers.len() as u32).collect(),
            ),
            numbers,
        }
    }
}

fn mesh(mesh: &fairform::Mesh, isolated: usize) -> MeshData {
    let mut positions = mesh.positions().to_vec();
    positions.resize(positions.len() + isolated, Vec3::new(-0.0, 0.5, 9.0));
    MeshData { positions, faces: mesh.topology().to_faces(), ..MeshData::default() }
}

/// An open sheet of quadrilaterals, some of them bent inwards.
fn quads(columns: u32, rows: u32) -> MeshData {
    let points = (0..(columns + 1) * (rows + 1)).map(|i| (i % (columns + 1), i / (columns + 1)));
    let bend = |x: u32, y: u32| if (x + y).is_multiple_of(5) { 0.7 } else { 0.0 };
    let place = |(x, y)| Vec3::new(f64::from(x) + bend(x, y), f64::from(y) + bend(x, y), 0.1);
    let cells = (0..rows).flat_map(|y| (0..columns).map(move |x| y * (columns + 1) + x));
    let corners = cells.flat_map(|v| [v, v + 1, v + columns + 2, v + columns + 1]).collect();
    let (positions, faces) = (points.map(place).collect(), Faces::uniform(4, corners));
    MeshData { positions, faces, ..MeshData::default() }
}

/// Triangles and quadrilaterals, open, closed and with vertices of no face, with all attributes in turn.
fn meshes() -> Vec<MeshData> {
    let kinds = [
        mesh(&fairform::shapes::torus(6, 8), 0),
        mesh(&fairform::shapes::cube(), 3),
        mesh(&fairform::shapes::icosahedron(), 1),
        quads(5, 4),
        MeshData { positions: vec![Vec3::new(1.0, 2.0, 0.1); 9], ..MeshData::default() },
        MeshData::default(),
    ];
    let mut all = Vec::new();
    for data in kinds {
        let (n, faces, corners) =
            (data.positions.len(), data.faces.len(), data.faces.corners().len());
        let labels = |names: &[&str], size: usize| Labels {
            names: names.iter().map(ToString::to_string).collect(),
            of_face: (0..faces).map(|f| ((f / size) % names.len()) as u32).collect(),
        };
        let normals = Some(data.positions.iter().map(|p| p.normalized()).collect());
        let shades = |colour: fn(usize) -> [f64; 4]| Some((0..n).map(colour).collect());
        let bytes = shades(|i| [(i % 256) as f64 / 255.0, 0.0, 1.0, 1.0]);
        let ones = shades(|i| [(i % 2) as f64, 0.0, 1.0, 1.0]);
        let fractions = shades(|i| [if i < 7 { 0.0 } else { 0.123 }, 0.0, 1.0, 1.0]);
        let opacity = shades(|i| [0.0, 0.0, 1.0, if i < 7 { 1.0 } else { 0.5 }]);
        all.push(data.clone());
        all.push(MeshData { normals: normals.clone(), ..data.clone() });
        for colours in [bytes, ones, fractions.clone(), opacity] {
            all.push(MeshData { colours, ..data.clone() });
        }
        let uvs = Some((0..n).map(|i| [i as f64 / 7.0, 0.5]).collect());
        let groups = Some(labels(&["", "a", "b c"], 5));
        let materials = Some(labels(&["red"], 1));
        let material_library = Some("a.mtl\nb.mtl".into());
        all.push(MeshData {
            uvs,
            normals,
            groups,
            materials,
            material_library,
            colours: fractions,
            ..data.clone()
        });
        let corner_uvs = Some((0..corners).map(|i| [i as f64 / 3.0, 1.0]).collect());
        all.push(MeshData { corner_uvs, materials: Some(labels(&["x", "y"], 2)), ..data });
    }
    all
}

fn ways() -> impl Iterator<Item = (Format, WriteOptions)> {
    Format::ALL.into_iter().flat_map(|format| {
        [(false, false), (false, true), (true, false), (true, true)].map(
            move |(ascii, single_precision)| (format, WriteOptions { ascii, single_precision }),
        )
    })
}

#[test]
fn blocks_make_the_same_bytes() {
    let mut compared = 0;
    for data in meshes() {
        for (format, options) in ways() {
            let (mut whole, mut streamed) = (Vec::new(), Vec::new());
            let notes = encode(format, &data, &options, &mut whole).unwrap();
            for size in [1, 7, 1000] {
                let cut = Cut { data: data.clone(), size };
                if !can_stream(format, &options, &cut.shape()) {
                    let refused = encode_blocks(format, &cut, &options, &mut streamed);
                    assert!(matches!(refused, Err(Error::Unwritable(_))), "{format}");
                    continue;
                }
                streamed.clear();
                let same = encode_blocks(format, &cut, &options, &mut streamed).unwrap();
                assert!(whole == streamed, "{format} {options:?} {size} {:?}", cut.shape());
                assert_eq!(notes, same, "{format} {options:?} {:?}", cut.shape());
                compared += 1;
            }
        }
    }
    assert!(compared > 1000, "{compared}");
}

#[test]
fn bytes_do_not_depend_on_threads() {
    let data = meshes().swap_remove(6);
    let cut = Cut { data, size: 3 };
    let bytes = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut out = Vec::new();
            encode_blocks(Format::Ply, &cut, &WriteOptions::default(), &mut out).unwrap();
            out
        })
    };
    let one = bytes(1);
    assert!(one == bytes(2) && one == bytes(5));
}

/// Makes a block another than was promised.
type Spoil = fn(&mut MeshData);

/// Blocks of another mesh than the shape promises.
struct Wrong<F>(Cut, F);

impl<F: Fn(&mut MeshData) + Sync> Blocks for Wrong<F> {
    fn shape(&self) -> Shape<'_> {
        self.0.shape()
    }

    fn vertex_block_count(&self) -> usize {
        self.0.vertex_block_count()
    }

    fn vertices(&self, block: usize, wanted: Attributes) -> MeshData {
        let mut data = self.0.vertices(block, wanted);
        if block == 5 {
            self.1(&mut data);
        }
        data
    }

    fn face_block_count(&self) -> usize {
        self.0.face_block_count()
    }

    fn faces(&self, block: usize) -> MeshData {
        let mut data = self.0.faces(block);
        if block == 5 {
            self.1(&mut data);
        }
        data
    }

    fn labels_before(&self, block: usize) -> [Option<u32>; 2] {
        self.0.labels_before(block)
    }

    fn patch(&self, block: usize) -> Patch {
        let mut patch = self.0.patch(block);
        if block == 5 {
            patch.faces = Faces::uniform(3, vec![0, 1, 99]);
        }
        patch
    }
}

/// Fails for each fault, and leaves no file, nor touches the one that was there.
#[test]
fn faults_are_found_and_leave_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mesh.ply");
    std::fs::write(&path, "old").unwrap();
    let faults: [(&str, Spoil); 6] = [
        ("vertices in", |data| *data = MeshData { normals: Some(vec![]), ..MeshData::default() }),
        ("values of vertices", |data| data.normals = data.normals.as_ref().map(|_| vec![])),
        ("faces", |data| data.faces = Faces::new()),
        ("vertex 77", |data| data.faces = Faces::uniform(3, vec![0, 1, 77])),
        ("not 3 corners", |data| data.faces = Faces::uniform(4, vec![0, 1, 2, 3])),
        ("attributes", |data| data.corner_uvs = Some(vec![[0.0; 2]; 3])),
    ];
    let data = || meshes().swap_remove(1);
    let write = |wrong: &dyn Blocks, format| {
        fairform_io::write_blocks(&path, Some(format), wrong, &WriteOptions::default())
    };
    for (what, fault) in faults {
        let error = write(&Wrong(Cut { data: data(), size: 1 }, fault), Format::Ply).unwrap_err();
        assert!(matches!(error, Error::Unwritable(_)), "{what}: {error:?}");
        assert!(error.to_string().contains(what), "{what}: {error}");
    }
    let nothing = |_: &mut MeshData| ();
    let wrong = Wrong(Cut { data: data(), size: 1 }, nothing);
    assert!(matches!(write(&wrong, Format::Stl), Err(Error::Unwritable(_))));
    assert_eq!(std::fs::read(&path).unwrap(), b"old");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "nothing else is left");
    write(&wrong, Format::Ply).unwrap();
    assert!(std::fs::read(&path).unwrap().starts_with(b"ply"));
}

/// A disk that is full.
#[test]
fn a_writer_that_fails_ends_it() {
    struct Full(usize);
    impl std::io::Write for Full {
        fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
            self.0 = self.0.checked_sub(bytes.len()).ok_or(std::io::ErrorKind::StorageFull)?;
            Ok(bytes.len())
        }

        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }
    let cut = Cut { data: meshes().swap_remove(1), size: 4 };
    for format in [Format::Ply, Format::Obj, Format::Off, Format::Stl, Format::Glb] {
        for room in [0, 30, 1000] {
            let error = encode_blocks(format, &cut, &WriteOptions::default(), &mut Full(room));
            assert!(matches!(error, Err(Error::Output(_))), "{format} {room}");
        }
    }
}

/// A mesh of which nothing is made before it is refused.
struct Huge(Shape<'static>);

impl Blocks for Huge {
    fn shape(&self) -> Shape<'_> {
        self.0.clone()
    }

    fn vertex_block_count(&self) -> usize {
        1 << 20
    }

    fn vertices(&self, _: usize, _: Attributes) -> MeshData {
        panic!("not to be made")
    }

    fn face_block_count(&self) -> usize {
        1 << 20
    }

    fn faces(&self, _: usize) -> MeshData {
        panic!("not to be made")
    }

    fn labels_before(&self, _: usize) -> [Option<u32>; 2] {
        [None; 2]
    }

    fn patch(&self, _: usize) -> Patch {
        panic!("not to be made")
    }
}

#[test]
fn what_a_format_cannot_hold_is_refused_at_once() {
    let shape = |vertex_count, face_count, face_size| Shape {
        vertex_count,
        face_count,
        face_size,
        ..Shape::default()
    };
    for (format, shape, why) in [
        (Format::Glb, shape(200_000_000, 200_000_000, 3), "4 GiB"),
        (Format::Stl, shape(2_000_000_000, 4_000_000_000, 4), "too many"),
        (Format::Ply, shape(5_000_000_000, 1, 3), "too many"),
        (Format::Ply, shape(9, 1, 2), "3 corners"),
    ] {
        let mut out = Vec::new();
        let error = encode_blocks(format, &Huge(shape), &WriteOptions::default(), &mut out);
        let error = error.unwrap_err().to_string();
        assert!(error.contains(why), "{error}");
        assert!(out.is_empty());
    }
}
