//! What several test files need: fixtures, comparisons, random meshes.
#![allow(dead_code, reason = "each test file uses a part of it")]

use fairform::interpolate::{Method, Options, interpolate};
use fairform::refine::{check_size, refine};
use fairform::{Faces, Mesh, Rules, Scheme, Topology, Vec3, limit, shapes};
use serde_json::Value;

/// A fixture of `data/golden`.
pub fn golden(name: &str) -> Value {
    let path = format!("{}/../../data/golden/{name}.json", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{path}: {e}"));
    serde_json::from_str(&text).unwrap_or_else(|e| panic!("{path}: {e}"))
}

/// The names of the fixtures in a folder of `data/golden`.
pub fn golden_names(folder: &str) -> Vec<String> {
    let path = format!("{}/../../data/golden/{folder}", env!("CARGO_MANIFEST_DIR"));
    let entries = std::fs::read_dir(&path).unwrap_or_else(|e| panic!("{path}: {e}"));
    let mut names: Vec<String> = entries
        .map(|entry| entry.unwrap().path().file_stem().unwrap().to_string_lossy().into_owned())
        .map(|stem| format!("{folder}/{stem}"))
        .collect();
    names.sort();
    names
}

pub fn points(value: &Value) -> Vec<Vec3> {
    let list = value.as_array().expect("a list of points");
    list.iter().map(|p| Vec3::new(number(&p[0]), number(&p[1]), number(&p[2]))).collect()
}

pub fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("a number, not {value}"))
}

pub fn faces(value: &Value) -> Faces {
    let face = |f: &Value| -> Vec<u32> {
        f.as_array().unwrap().iter().map(|v| v.as_u64().unwrap() as u32).collect()
    };
    value.as_array().expect("a list of faces").iter().map(face).collect()
}

pub fn mesh(value: &Value) -> Mesh {
    Mesh::new(points(&value["vertices"]), &faces(&value["faces"])).expect("a manifold")
}

/// Fails where two lists of points differ by more than `tolerance` times the size of `expected`.
#[track_caller]
pub fn assert_near(actual: &[Vec3], expected: &[Vec3], tolerance: f64, what: &str) {
    assert_eq!(actual.len(), expected.len(), "{what}: count");
    let size = expected.iter().map(|p| p.max_abs()).fold(1e-300, f64::max);
    for (i, (a, e)) in actual.iter().zip(expected).enumerate() {
        let error = (*a - *e).length() / size;
        assert!(error <= tolerance, "{what}: point {i} is {a:?}, not {e:?} (off by {error:e})");
    }
}

/// Meshes with and without boundary, regular and not, valences 2 to 40.
pub fn assorted() -> Vec<(&'static str, Mesh)> {
    vec![
        ("tetrahedron", shapes::tetrahedron()),
        ("octahedron", shapes::octahedron()),
        ("icosahedron", shapes::icosahedron()),
        ("torus", shapes::torus(5, 7)),
        ("bipyramid 3", shapes::bipyramid(3)),
        ("bipyramid 40", shapes::bipyramid(40)),
        ("fan 3", shapes::fan(3)),
        ("fan 9", shapes::fan(9)),
        ("sheet", shapes::sheet(5, 6, |x, y| (3.0 * x).sin() * y)),
        ("strip", shapes::sheet(2, 6, |x, y| x * y)),
        ("tube", shapes::tube(4, 7)),
        ("triangle", triangle()),
        ("back to back", back_to_back()),
        ("several", several()),
    ]
}

pub fn triangle() -> Mesh {
    let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.2, 1.0, 0.3]].map(Vec3::from);
    Mesh::new(positions.to_vec(), &Faces::uniform(3, vec![0, 1, 2])).unwrap()
}

/// Two triangles glued on all sides: three interior vertices of valence 2.
pub fn back_to_back() -> Mesh {
    Mesh::new(triangle().into_positions(), &Faces::uniform(3, vec![0, 1, 2, 2, 1, 0])).unwrap()
}

/// A closed and an open component and two isolated vertices.
pub fn several() -> Mesh {
    let (a, b) = (shapes::icosahedron(), shapes::fan(5));
    let mut positions = vec![Vec3::new(9.0, 9.0, 9.0)];
    positions.extend(a.positions());
    positions.extend(b.positions().iter().map(|&p| p + Vec3::new(5.0, 0.0, 0.0)));
    positions.push(Vec3::new(-7.0, 0.0, 3.0));
    let mut list = Faces::new();
    for (shape, offset) in [(&a, 1), (&b, 13)] {
        for f in shape.topology().to_faces().iter() {
            list.push(&f.iter().map(|v| v + offset).collect::<Vec<_>>());
        }
    }
    Mesh::new(positions, &list).unwrap()
}

/// A closed or open triangle mesh grown from a seed: a shape whose faces are randomly split at
/// their centre (valence 3, and ever higher ones), with random positions and some faces cut out.
pub fn random_mesh(seed: u64, splits: usize, holes: usize) -> Mesh {
    let mut state = seed | 1;
    let mut random = move |below: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as usize % below
    };
    let base = match random(4) {
        0 => shapes::tetrahedron(),
        1 => shapes::octahedron(),
        2 => shapes::torus(3 + random(4) as u32, 3 + random(4) as u32),
        _ => shapes::bipyramid(3 + random(20) as u32),
    };
    let mut positions = base.positions().to_vec();
    let mut list: Vec<[u32; 3]> =
        base.topology().to_faces().iter().map(|f| [f[0], f[1], f[2]]).collect();
    for _ in 0..splits {
        let f = random(list.len());
        let [a, b, c] = list[f];
        let n = positions.len() as u32;
        positions.push(Vec3::ZERO);
        list[f] = [a, b, n];
        list.push([b, c, n]);
        list.push([c, a, n]);
    }
    for p in &mut positions {
        let mut coordinate = || random(1 << 20) as f64 / f64::from(1 << 19) - 1.0;
        *p = Vec3::new(coordinate(), coordinate(), coordinate());
    }
    // Cut faces out one by one, wherever that leaves a manifold.
    for _ in 0..holes {
        if list.len() < 2 {
            break;
        }
        let f = random(list.len());
        let mut fewer = list.clone();
        fewer.swap_remove(f);
        let candidate: Faces = fewer.iter().collect();
        if Topology::from_faces(positions.len(), &candidate).is_ok() {
            list = fewer;
        }
    }
    Mesh::new(positions, &list.iter().collect()).expect("a manifold")
}

/// Closed and open polygon meshes: quads, n-gons, valences 2 to 12.
pub fn polygons() -> Vec<(&'static str, Mesh)> {
    vec![
        ("cube", shapes::cube()),
        ("prism 5", prism(5)),
        ("prism 6", prism(6)),
        ("quad torus", quad_torus(4, 6)),
        ("quad sheet", quad_sheet(4, 5)),
        ("strip", quad_sheet(2, 5)),
        ("one quad", quad_sheet(2, 2)),
        ("mixed", mixed()),
        ("octahedron", shapes::octahedron()),
        ("bipyramid 12", shapes::bipyramid(12)),
        ("fan 7", shapes::fan(7)),
        ("several", several()),
    ]
}

/// Two `n`-gons and `n` quads, bumpy.
pub fn prism(n: u32) -> Mesh {
    let at = |i: u32, z: f64| {
        let u = 2.0 * std::f64::consts::PI * f64::from(i) / f64::from(n);
        Vec3::new(libm::cos(u), libm::sin(u), z + 0.1 * libm::sin(3.0 * u + z))
    };
    let positions = (0..n).map(|i| at(i, 0.0)).chain((0..n).map(|i| at(i, 1.0))).collect();
    let mut faces: Faces = (0..n).map(|i| [i, (i + 1) % n, n + (i + 1) % n, n + i]).collect();
    faces.push(&(0..n).rev().collect::<Vec<_>>());
    faces.push(&(n..2 * n).collect::<Vec<_>>());
    Mesh::new(positions, &faces).unwrap()
}

pub fn quad_torus(rows: u32, columns: u32) -> Mesh {
    let at = |i: u32, j: u32| i % rows * columns + j % columns;
    let faces: Faces = (0..rows * columns)
        .map(|k| (k / columns, k % columns))
        .map(|(i, j)| [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)])
        .collect();
    Mesh::new(shapes::torus(rows.max(3), columns).into_positions(), &faces).unwrap()
}

pub fn quad_sheet(rows: u32, columns: u32) -> Mesh {
    let at = |i: u32, j: u32| i * columns + j;
    let faces: Faces = (0..(rows - 1) * (columns - 1))
        .map(|k| (k / (columns - 1), k % (columns - 1)))
        .map(|(i, j)| [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)])
        .collect();
    let height = |x: f64, y: f64| libm::sin(4.0 * x) * y + 0.3 * x * x;
    Mesh::new(shapes::sheet(rows, columns, height).into_positions(), &faces).unwrap()
}

/// A triangle, a quad and a pentagon side by side, open.
pub fn mixed() -> Mesh {
    let faces: Faces = [&[0, 1, 2][..], &[1, 3, 4, 2], &[4, 3, 5, 6, 7]].into_iter().collect();
    let positions = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.2],
        [0.5, 1.0, 0.0],
        [2.0, 0.1, 0.3],
        [1.6, 1.2, -0.2],
        [3.0, 0.2, 0.1],
        [3.2, 1.1, 0.0],
        [2.4, 1.8, 0.4],
    ];
    Mesh::new(positions.map(Vec3::from).to_vec(), &faces).unwrap()
}

/// Some edges and vertices made sharp, for a while or for ever, from a seed.
pub fn random_creases(topology: &Topology, seed: u64, share: u64) -> fairform::Creases {
    let mut state = seed | 1;
    let mut random = move |below: u64| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) % below
    };
    let mut creases = fairform::Creases::smooth(topology);
    let sharpness = [0.4, 1.0, 1.7, 2.5, 10.0, 10.0, 10.0];
    for e in topology.edges() {
        if random(100) < share {
            creases.set_edge(e, sharpness[random(7) as usize]).unwrap();
        }
    }
    for v in topology.vertices() {
        if random(100) < share / 4 {
            creases.set_vertex(v, sharpness[random(7) as usize]).unwrap();
        }
    }
    creases
}

pub fn limit_points(mesh: &Mesh, rules: &Rules) -> Vec<Vec3> {
    limit::limit_points(mesh.topology(), mesh.positions(), rules).unwrap()
}

/// Closed form equals search, rows equal rule, weights sum to one, a step keeps the limit points.
pub fn check_step(mesh: &Mesh, rules: &Rules, name: &str) {
    let coarse = mesh.topology();
    let step = refine(coarse, rules).unwrap();
    let size = check_size(coarse, rules, 1).unwrap();
    let finer = &step.topology;
    assert!(finer.vertex_count() as u64 <= size.vertex_count, "{name}");
    if rules.scheme == Scheme::CatmullClark {
        assert_eq!(finer.edge_count() as u64, size.edge_count, "{name}");
        let found = Topology::from_faces(finer.vertex_count(), &finer.to_faces()).unwrap();
        assert_eq!(*finer, found, "{name}");
    }
    for f in finer.faces() {
        assert!(step.parent(f).index() < coarse.face_count(), "{name}");
    }
    let stencils = step.stencils();
    let positions = step.apply(mesh.positions());
    assert_near(&stencils.apply(mesh.positions()), &positions, 4e-15, name);
    for row in 0..stencils.row_count() {
        let sum: f64 = stencils.row(row).map(|(_, w)| w).sum();
        assert!((sum - 1.0).abs() < 1e-14, "{name} row {row}");
    }
    let rows = limit::limit_stencils(coarse, rules).unwrap();
    let before = limit_points(mesh, rules);
    assert_near(&rows.apply(mesh.positions()), &before, 4e-15, name);
    if rules.scheme != Scheme::DooSabin {
        let after = limit_points(&Mesh::from_parts(step.topology.into(), positions), &step.next);
        assert_near(&after[..before.len()], &before, 1e-13, name);
    }
}

pub fn check_fit(target: &Mesh, rules: &Rules, method: Method, name: &str) {
    let options = Options { method, ..Options::default() };
    let (control, report) = interpolate(target, rules, &options).unwrap();
    assert!(report.is_converged(), "{name} {} {method}: {}", rules.scheme, report.max);
    let limit = limit_points(&control, rules);
    let off = limit.iter().zip(target.positions()).map(|(a, b)| (*a - *b).length());
    let worst = off.fold(0.0, f64::max) / report.unit;
    assert!(worst <= 1.01e-6, "{name} {} {method}: {worst:e}", rules.scheme);
}

/// The smallest pivot of a symmetric matrix: by Cholesky's factorisation, which exists exactly for
/// positive definite ones.
pub fn smallest_pivot(mut s: Vec<Vec<f64>>) -> f64 {
    let mut smallest = f64::INFINITY;
    for k in 0..s.len() {
        let pivot = s[k][k];
        smallest = smallest.min(pivot);
        if pivot.is_nan() || pivot <= 0.0 {
            break;
        }
        let upper = s[k].clone();
        for line in &mut s[k + 1..] {
            let factor = line[k] / pivot;
            for (x, u) in line[k..].iter_mut().zip(&upper[k..]) {
                *x -= factor * u;
            }
        }
    }
    smallest
}
