//! What streams, what is in memory and what is made step by step are the same.

use fairform::{Border, Corners, Rules, shapes};
use fairform_io::{Format, WriteOptions, can_stream, encode, encode_blocks};

use super::*;
use crate::console::Console;
use crate::input::Source;

fn surface(mesh: &fairform::Mesh, rules: Rules, attributes: bool) -> Surface {
    let faces = mesh.topology().to_faces();
    let mut positions = mesh.positions().to_vec();
    positions.push(Vec3::new(3.0, 1.0, 0.5));
    let mut data = MeshData { positions, faces, ..MeshData::default() };
    if attributes {
        let (n, f) = (data.positions.len(), data.faces.len());
        let labels = |names: [&str; 2], size: usize| Labels {
            names: names.map(String::from).to_vec(),
            of_face: (0..f).map(|f| (f / size % 2) as u32).collect(),
        };
        data.normals = Some(data.positions.iter().map(|p| p.normalized()).collect());
        let colour = |i: usize| [i as f64 / n as f64, 0.5, 0.25, if i == 3 { 0.5 } else { 1.0 }];
        data.colours = Some((0..n).map(colour).collect());
        data.uvs = Some((0..n).map(|i| [i as f64, 0.5]).collect());
        data.groups = Some(labels(["", "a"], 3));
        data.materials = Some(labels(["red", "blue"], 2));
        data.material_library = Some("a.mtl".into());
    }
    let source = Source { path: Path::new("test"), format: None };
    let mut surface = Surface::new(data, &source).unwrap();
    surface.rules = rules;
    surface
}

/// A seam: texture coordinates of corners, each with a place of its own.
fn with_seams(mut surface: Surface) -> Surface {
    let corners = surface.mesh.topology().halfedge_count();
    let uv = |i: usize| Vec3::new(i as f64, (i * i % 7) as f64, 0.0);
    surface.corner_uvs = Some((0..corners).map(uv).collect());
    surface.fields.uvs = None;
    surface
}

fn quads() -> fairform::Mesh {
    let cube = shapes::cube();
    let kept: Faces = cube.topology().to_faces().iter().skip(1).collect();
    fairform::Mesh::new(cube.positions().to_vec(), &kept).unwrap()
}

/// Open and closed, of triangles and quadrilaterals, with and without attributes, creases and faces
/// that are not shown.
fn surfaces() -> Vec<(Surface, Finish)> {
    let catmull_clark = Rules { corners: Corners::Sharp, ..Scheme::CatmullClark.into() };
    let mut all = Vec::new();
    for finish in [Finish::Control, Finish::LimitNormals, Finish::Limit] {
        all.push((surface(&shapes::octahedron(), Rules::LOOP, false), finish));
        all.push((surface(&shapes::tube(3, 5), Rules::LOOP, true), finish));
        all.push((with_seams(surface(&shapes::octahedron(), Rules::LOOP, true)), finish));
        all.push((surface(&shapes::cube(), catmull_clark.clone(), true), finish));
        all.push((with_seams(surface(&quads(), catmull_clark.clone(), true)), finish));
        let mut hidden = surface(&quads(), catmull_clark.clone(), true);
        hidden.shown = Some([true, false, true, true, false].into());
        all.push((hidden, finish));
    }
    let mut creased = surface(&shapes::tube(3, 5), Rules::LOOP, true);
    let (topology, positions) = (creased.mesh.topology(), creased.mesh.positions());
    let creases = fairform::Creases::by_angle(topology, positions, 20.0, 1.5).unwrap();
    assert!(!creases.is_smooth());
    creased.rules = Rules { creases: Some(creases.into()), border: Border::Bspline, ..Rules::LOOP };
    all.push((creased, Finish::Control));
    all
}

#[test]
fn what_streams_is_what_is_in_memory() {
    let console = Console::new(true, false, false);
    let progress = console.progress();
    let mut compared = 0;
    for (surface, finish) in surfaces() {
        let levels = 3;
        assert!(surface.goes_at_once(levels, finish));
        let fine = surface.tessellation(levels, finish).unwrap();
        let blocks = Fine::new(&surface, &fine, finish, &progress).unwrap();
        let data = surface.refined(levels, finish, &progress, None).unwrap();
        assert_eq!(blocks.origins().len(), data.faces.len());
        for format in Format::ALL {
            for (ascii, single_precision) in [(false, true), (true, false)] {
                let options = WriteOptions { ascii, single_precision };
                if !can_stream(format, &options, &surface.fine_shape(finish)) {
                    continue;
                }
                let (mut whole, mut streamed) = (Vec::new(), Vec::new());
                let notes = encode(format, &data, &options, &mut whole).unwrap();
                let same = encode_blocks(format, &blocks, &options, &mut streamed).unwrap();
                assert!(whole == streamed, "{format} {:?}", blocks.shape());
                assert_eq!(notes, same, "{format}");
                compared += 1;
            }
        }
    }
    assert!(compared > 100, "{compared}");
}

/// What a vertex is and has, rounded.
fn vertex(data: &MeshData, v: u32) -> Vec<i64> {
    let v = v as usize;
    let mut all: Vec<f64> = <[f64; 3]>::from(data.positions[v]).to_vec();
    all.extend(data.normals.iter().flat_map(|n| <[f64; 3]>::from(n[v])));
    all.extend(data.colours.iter().flat_map(|c| c[v]));
    all.extend(data.uvs.iter().flat_map(|uv| uv[v]));
    // Off the places where rounding up and down is near.
    all.into_iter().map(|x| (x * 1e6 + 0.123).round() as i64).collect()
}

/// Corners from the least on, group and material.
type Face = (Vec<Vec<i64>>, Option<u32>, Option<u32>);

/// All faces with what their corners are and have, sorted.
fn faces(data: &MeshData) -> Vec<Face> {
    let mut corner = 0;
    let mut all: Vec<_> = (0..data.faces.len())
        .map(|f| {
            let of = |v: &u32| {
                let mut all = vertex(data, *v);
                let uvs = data.corner_uvs.iter().flat_map(|uvs| uvs[corner]);
                all.extend(uvs.map(|x| (x * 1e6 + 0.123).round() as i64));
                corner += 1;
                all
            };
            let mut list: Vec<_> = data.faces.get(FaceId(f as u32)).iter().map(of).collect();
            let first = (0..list.len()).min_by_key(|&i| list[i].clone()).unwrap();
            list.rotate_left(first);
            let label = |labels: &Option<Labels>| labels.as_ref().map(|l| l.of_face[f]);
            (list, label(&data.groups), label(&data.materials))
        })
        .collect();
    all.sort();
    all
}

#[test]
fn steps_at_once_are_the_steps() {
    let console = Console::new(true, false, false);
    let progress = console.progress();
    for (surface, finish) in surfaces() {
        let levels = 3;
        let data = surface.refined(levels, finish, &progress, None).unwrap();
        let mut stepped = surface.refine(levels, &progress).unwrap();
        match finish {
            Finish::Control => {}
            Finish::LimitNormals => stepped.limit_normals().unwrap(),
            Finish::Limit => stepped.move_to_limit().unwrap(),
        }
        let stepped = stepped.into_surface();
        assert_eq!(data.positions.len(), stepped.positions.len());
        let count = surface.mesh.positions().len() as u32;
        for v in 0..count {
            assert_eq!(vertex(&data, v), vertex(&stepped, v), "vertex {v} keeps its number");
        }
        assert!(faces(&data) == faces(&stepped), "{finish:?}");
        assert_eq!(data.material_library, stepped.material_library);
    }
}
