//! The example models of `data/streamline` are what their README says: sizes, lengths, symmetry, no
//! folds.

use std::path::Path;

use crate::common::{number, points};
use fairform::sphere::Ends;
use fairform::streamline::{Grid, InitialCurve, Model, Order, Start, Surface};
use fairform::{Mesh, Scheme, Vec3};
use serde_json::Value;

/// Refinement steps in these tests.
const DEPTH: u32 = 3;

fn read(name: &str) -> Value {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/streamline");
    let path = folder.join(format!("{name}.streamline.json"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    assert!(text.len() < 30_000, "{name}: {} bytes", text.len());
    let file: Value = serde_json::from_str(&text).unwrap_or_else(|e| panic!("{name}: {e}"));
    assert_eq!((&file["version"], file["name"].as_str()), (&Value::from(1), Some(name)));
    file
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(number).collect()
}

fn model(patch: &Value) -> Model {
    let rows = |field: &str| patch[field].as_array().expect("rows").iter();
    let initial = &patch["initial"];
    assert_eq!(initial["type"], "bspline");
    let initial = InitialCurve::Bspline {
        points: points(&initial["points"]),
        weights: None,
        degree: initial["degree"].as_u64().unwrap() as usize,
        knots: None,
        t0: number(&initial["t0"]),
        t1: number(&initial["t1"]),
    };
    let tangents = Grid::from_rows(rows("tangents").map(points)).unwrap();
    Model {
        s: Grid::from_rows(rows("s").map(numbers)).unwrap(),
        start: match &patch["s0"] {
            Value::String(name) if name == "min" => Start::Min,
            other => Start::Fraction(number(&other["fraction"])),
        },
        scheme: patch["scheme"].as_str().unwrap().parse().unwrap(),
        order: if patch["order"] == "st" { Order::St } else { Order::Ts },
        ends: if patch["ends"] == "clamped" { Ends::Clamped } else { Ends::Natural },
        depth: DEPTH,
        ..Model::new(tangents, &[], numbers(&patch["t"]), initial)
    }
}

fn surface(name: &str) -> Surface {
    Surface::new(model(&read(name))).unwrap_or_else(|e| panic!("{name}: {e}"))
}

/// Name, scheme, tangents given, tangents after three steps.
const MODELS: [(&str, Scheme, [usize; 2], [usize; 2]); 5] = [
    ("car", Scheme::Kobbelt, [6, 9], [41, 65]),
    ("saddle", Scheme::CatmullClark, [7, 7], [35, 35]),
    ("duct", Scheme::Kobbelt, [17, 10], [129, 73]),
    ("hull", Scheme::Kobbelt, [7, 9], [49, 65]),
    ("chair", Scheme::DooSabin, [7, 12], [42, 82]),
];

fn size<T>(grid: &Grid<T>) -> [usize; 2] {
    [grid.row_count(), grid.column_count()]
}

#[test]
fn the_models_have_the_sizes_promised() {
    for (name, scheme, given, refined) in MODELS {
        let surface = surface(name);
        assert_eq!(surface.model().scheme, scheme, "{name}");
        assert_eq!(size(&surface.model().tangents), given, "{name}");
        assert_eq!(size(surface.tangents()), refined, "{name}");
        assert!(surface.model().warnings().is_empty(), "{name}: {:?}", surface.model().warnings());
    }
}

/// Refinement of neighbours that point in nearly opposite directions is right, but a small edit
/// would throw it to the other side: not what one wants to be shown first.
#[test]
fn neighbouring_tangents_are_far_from_opposite() {
    for (name, ..) in MODELS {
        let tangents = surface(name).into_model().tangents;
        for k in 0..tangents.row_count() {
            for i in 0..tangents.column_count() {
                let t = tangents.row(k)[i];
                let along = tangents.row(k).get(i + 1);
                let across = (k + 1 < tangents.row_count()).then(|| &tangents.row(k + 1)[i]);
                for other in along.into_iter().chain(across) {
                    assert!(t.dot(*other) > -0.6, "{name}: tangent ({k}, {i})");
                }
            }
        }
    }
}

#[test]
fn streamlines_have_the_lengths_asked_for() {
    for (name, ..) in MODELS {
        let surface = surface(name);
        let asked = &surface.model().s;
        let points = surface.points();
        for k in 0..points.row_count() {
            let row = points.row(k);
            let polygon: f64 = row.windows(2).map(|p| (p[1] - p[0]).length()).sum();
            assert!((polygon - surface.length(k)).abs() < 1e-12 * polygon, "{name}: row {k}");
        }
        // The first and the last streamline are those given, under every rule here.
        for (given, refined) in [(0, 0), (asked.row_count() - 1, points.row_count() - 1)] {
            let s = asked.row(given);
            let length = s[s.len() - 1] - s[0];
            assert!((surface.length(refined) - length).abs() < 1e-12 * length, "{name}");
        }
    }
}

fn face_normal(mesh: &Mesh, face: fairform::FaceId) -> Vec3 {
    let corners = mesh.topology().face_vertices(face);
    let p = |i: usize| mesh.positions()[corners[i].index()];
    let normal = (p(2) - p(0)).cross(p(3) - p(1));
    assert!(normal.length() > 0.0, "face {face} has no area");
    normal.normalized()
}

/// Over a fold the normal turns round. Only the bow of the hull is meant to be as sharp as that: there
/// the keel, the middle streamline, is an edge.
#[test]
fn no_surface_is_folded() {
    for (name, ..) in MODELS {
        let surface = surface(name);
        let mesh = surface.mesh().unwrap_or_else(|e| panic!("{name}: {e}"));
        let topology = mesh.topology();
        assert_eq!(topology.boundary_loops().len(), 1, "{name}");
        let [rows, columns] = size(surface.points());
        let is_bow = |h| {
            let v = topology.origin(h).index();
            name == "hull" && v / columns == rows / 2 && v % columns < 4
        };
        for h in topology.halfedges() {
            let Some(twin) = topology.twin(h) else { continue };
            if is_bow(h) && is_bow(twin) {
                continue;
            }
            let [a, b] = [h, twin].map(|h| face_normal(&mesh, topology.face(h)));
            let at = topology.origin(h).index();
            let (row, column) = (at / columns, at % columns);
            assert!(a.dot(b) > 0.25, "{name}: cosine {} at point ({row}, {column})", a.dot(b));
        }
    }
}

/// Left and right of the plane x = 0.
#[test]
fn car_hull_chair_and_saddle_are_symmetric() {
    for name in ["car", "hull", "chair", "saddle"] {
        let surface = surface(name);
        let points = surface.points();
        for k in 0..points.row_count() {
            let mirrored = points.row(points.row_count() - 1 - k);
            for (p, q) in points.row(k).iter().zip(mirrored) {
                let distance = (*p - Vec3::new(-q.x, q.y, q.z)).length();
                assert!(distance < 1e-6, "{name}: row {k} is off by {distance:e}");
            }
        }
    }
}

#[test]
fn the_duct_is_closed() {
    let surface = surface("duct");
    let points = surface.points();
    assert_eq!(points.row(0), points.row(points.row_count() - 1));
}

/// In metres: as long, wide and high as a small saloon, with a bonnet and a boot below the roof.
#[test]
fn the_car_is_as_large_as_a_car() {
    let surface = surface("car");
    let size = surface.mesh().unwrap().bounds().size();
    assert!((4.2..4.5).contains(&size.z), "long {}", size.z);
    assert!((1.7..1.85).contains(&size.x), "wide {}", size.x);
    assert!((1.15..1.3).contains(&size.y), "high {}", size.y);
    let points = surface.points();
    let middle = points.row(points.row_count() / 2);
    let height = |z: f64| {
        let above = middle.iter().filter(|p| (p.z - z).abs() < 0.1);
        above.map(|p| p.y).fold(f64::NEG_INFINITY, f64::max)
    };
    let [bonnet, roof, boot] = [1.2, -0.3, -1.8].map(height);
    assert!(roof > bonnet + 0.3 && roof > boot + 0.25, "{bonnet} {roof} {boot}");
}
