//! Project files: what is written reads back, and what is wrong is named by its field.

use fairform::interpolate::Method;
use fairform::{Border, Corners, Mesh, Rules, Scheme, Vec3, crease};
use fairform_io::project::{
    Camera, Design, FOR_EVER, Fineness, MeshPart, Project, Workspace, encode, parse,
};
use fairform_io::{CreaseList, Format};
use proptest::prelude::*;
use serde_json::{Value, json};

fn number() -> impl Strategy<Value = f64> {
    prop_oneof![any::<f64>().prop_filter("finite", |x| x.is_finite()), -10.0..10.0, Just(0.1)]
}

fn design() -> impl Strategy<Value = Design> {
    let share = || (f64::MIN_POSITIVE..=1.0).boxed();
    let choices = (
        prop::sample::select(Scheme::ALL),
        prop::sample::select(&Method::ALL[..]),
        prop::sample::select(vec![Corners::Smooth, Corners::Sharp]),
        prop::sample::select(vec![Border::Bspline, Border::Drop, Border::None]),
    );
    let numbers = (f64::MIN_POSITIVE..1e300, any::<u32>(), any::<bool>());
    let lists = (
        prop::option::of(0.0..=1.0),
        prop::option::of(share()),
        prop::collection::vec((any::<u32>(), share()), 0..4),
        prop::collection::vec(
            (any::<u32>(), any::<u32>(), prop_oneof![Just(FOR_EVER), 0.0..1e9]),
            0..4,
        ),
        prop::collection::vec((any::<u32>(), number(), number(), number()), 0..4),
    );
    (choices, numbers, lists).prop_map(|(choices, numbers, lists)| {
        let (scheme, method, corners, border) = choices;
        let (tolerance, iterations, exact) = numbers;
        let (fair, tension, tensions, creases, moves) = lists;
        Design {
            scheme,
            method,
            tolerance,
            iterations,
            exact,
            fair,
            corners,
            border,
            tension,
            tensions,
            creases,
            moves,
        }
    })
}

fn value() -> impl Strategy<Value = Value> {
    let leaf = prop_oneof![
        Just(Value::Null),
        any::<bool>().prop_map(Value::from),
        number().prop_map(Value::from),
        any::<i64>().prop_map(Value::from),
        ".*".prop_map(Value::from),
    ];
    leaf.prop_recursive(3, 16, 4, |inner| {
        prop_oneof![
            prop::collection::vec(inner.clone(), 0..4).prop_map(Value::from),
            prop::collection::btree_map(".*", inner, 0..4)
                .prop_map(|map| Value::Object(map.into_iter().collect())),
        ]
    })
}

fn mesh_part() -> impl Strategy<Value = MeshPart> {
    let name = prop::sample::select(vec!["a.obj", "größe.ply.gz", "with space.STL", "x.glb"]);
    let repairs = prop::sample::subsequence(vec!["weld", "orient", "split", "fill-holes=7"], 0..4);
    let numbers = || prop::collection::vec(any::<u32>(), 0..5);
    let fineness = (0..=6_u32, any::<bool>());
    let bytes = prop::collection::vec(any::<u8>(), 0..40);
    (name, bytes, repairs, design(), fineness, numbers(), numbers()).prop_map(
        |(name, bytes, repairs, design, (levels, limit), faces, vertices)| MeshPart {
            repairs: repairs.into_iter().map(Into::into).collect(),
            design,
            fineness: Fineness { levels, limit },
            faces,
            vertices,
            ..MeshPart::new(name, bytes)
        },
    )
}

fn camera() -> impl Strategy<Value = Camera> {
    let triple = || [number(), number(), number()];
    (triple(), triple(), triple(), number()).prop_map(|(position, target, up, zoom)| Camera {
        position,
        target,
        up,
        zoom,
    })
}

proptest! {
    #[test]
    fn what_is_written_reads_back(
        mesh in prop::option::of(mesh_part()),
        camera in prop::option::of(camera()),
        studio in value(),
        is_stream in any::<bool>(),
    ) {
        let workspace =
            if is_stream { Workspace::Streamline } else { Workspace::Interpolation };
        let project = Project { workspace, mesh, camera, studio, ..Project::default() };
        let bytes = encode(&project);
        prop_assert_eq!(parse(&bytes).unwrap(), project.clone());
        prop_assert_eq!(encode(&project), bytes);
    }

    /// Any change of a byte gives a project or an error, never a panic.
    #[test]
    fn damaged_files_are_answered(mesh in mesh_part(), at in any::<prop::sample::Index>(), byte: u8) {
        let mut bytes = encode(&Project { mesh: Some(mesh), ..Project::default() });
        let at = at.index(bytes.len());
        bytes[at] = byte;
        let _ = parse(&bytes).map(|p| p.mesh.map(|m| m.data()));
    }
}

fn with_mesh(change: impl FnOnce(&mut Value)) -> Value {
    let mut project = json!({"fairform": 1, "mesh": {"name": "a.obj", "bytes": "diAwIDAgMAo="}});
    change(&mut project);
    project
}

#[test]
fn what_is_wrong_is_named_by_its_field() {
    let mesh = |field: &'static str, value: Value| with_mesh(|p| p["mesh"][field] = value);
    let design = |field: &'static str, value: Value| mesh("design", json!({ field: value }));
    let cases = [
        (json!({}), "fairform: missing"),
        (json!({"fairform": 2}), "fairform: version 2; expected 1"),
        (json!({"fairform": "1"}), "fairform: version \"1\""),
        (json!({"fairform": 1, "mash": 0}), "mash: unknown field `mash`"),
        (json!({"fairform": 1, "workspace": "sculpture"}), "workspace: unknown variant"),
        (mesh("name", json!(7)), "mesh.name: invalid type"),
        (mesh("name", json!("a.step")), "mesh.name: \"a.step\"; expected a name that tells"),
        (mesh("bytes", json!("?")), "mesh.bytes: no base64"),
        (mesh("repairs", json!(["glue"])), "mesh.repairs: no such repair step: \"glue\""),
        (mesh("fineness", json!({"levels": 7})), "mesh.fineness.levels: 7; expected 0 to 6"),
        (design("scheme", json!("lop")), "mesh.design.scheme: \"lop\": no such scheme"),
        (design("method", json!("fast")), "mesh.design.method: \"fast\": expected one of"),
        (design("corners", json!("round")), "mesh.design.corners: \"round\": expected one of"),
        (design("tolerance", json!(0)), "mesh.design.tolerance: 0; expected a positive"),
        (design("fair", json!(2)), "mesh.design.fair: 2; expected 0 to 1"),
        (design("tension", json!(0)), "mesh.design.tension: 0; expected above 0"),
        (design("tensions", json!([[0, 0.5], [1, 2]])), "mesh.design.tensions[1]: 2; expected"),
        (design("creases", json!([[0, 1, -2]])), "mesh.design.creases[0]: -2; expected"),
        (design("creases", json!([[0, 1]])), "mesh.design.creases[0]: invalid length 2"),
        (design("moves", json!([[0, 1, 2, null]])), "mesh.design.moves[0][3]: invalid type"),
        (json!({"fairform": 1, "camera": {"zoom": 1}}), "camera: missing field `position`"),
        (json!({"fairform": 1, "model": {"tangents": 3}}), "model.tangents: "),
    ];
    for (project, expected) in cases {
        let error = parse(project.to_string().as_bytes()).unwrap_err().to_string();
        assert!(error.contains(expected), "{project}: {error}, not {expected}");
    }
    let error = parse(b"{\n  \"fairform\": 1,\n  oops").unwrap_err().to_string();
    assert!(error.starts_with("line 3, column "), "{error}");
    let error = parse(b"{\"fairform\": 1} x").unwrap_err().to_string();
    assert!(error.contains("line 1"), "{error}");
}

/// A project is the mesh with repairs and moves, and the rules of its design.
#[test]
fn a_project_makes_a_mesh_and_rules() {
    let off = b"OFF 5 3 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n2 0 0\n3 0 1 2\n3 0 3 2\n3 1 4 2\n".to_vec();
    let mut part = MeshPart::new("three.off", off);
    assert!(Mesh::new(part.given().unwrap().positions, &part.given().unwrap().faces).is_err());
    part.repairs.push("orient".into());
    part.design = Design {
        tension: Some(0.6),
        tensions: vec![(1, 0.9)],
        creases: vec![(0, 2, FOR_EVER), (1, 2, 2.5)],
        moves: vec![(4, 3.0, 0.0, 1.0)],
        ..Design::default()
    };
    let data = part.data().unwrap();
    assert_eq!(data.positions[4], Vec3::new(3.0, 0.0, 1.0));
    assert_eq!(part.given().unwrap().positions[4], Vec3::new(2.0, 0.0, 0.0));
    let mesh = Mesh::new(data.positions, &data.faces).unwrap();
    let file = CreaseList { vertices: vec![(4, 10.0)], ..CreaseList::default() };
    let (rules, notes) = part.design.rules(&mesh, Some(&file)).unwrap();
    assert_eq!(notes, Vec::<String>::new());
    assert_eq!(rules.tension.as_deref(), Some(&[0.6, 0.9, 0.6][..]));
    let creases = rules.creases.unwrap();
    let sharp: Vec<f64> = mesh.topology().edges().map(|e| creases.edge(e)).collect();
    assert_eq!(sharp.iter().filter(|s| **s > 0.0).count(), 2);
    assert!(sharp.contains(&crease::INFINITE) && sharp.contains(&2.5));
    assert_eq!(creases.vertex(fairform::VertexId(4)), 10.0);

    let options = part.design.options();
    assert_eq!((options.tolerance, options.fair), (Some(1e-6), None));
    let butterfly = Design { scheme: Scheme::Butterfly, ..part.design.clone() };
    let (rules, notes) = butterfly.rules(&mesh, None).unwrap();
    assert_eq!(rules, Rules::from(Scheme::Butterfly));
    assert_eq!(notes.len(), 2, "{notes:?}");
    let plain = Design::default().rules(&mesh, None).unwrap();
    assert_eq!(plain, (Rules::LOOP, Vec::new()));

    part.design.moves.push((5, 0.0, 0.0, 0.0));
    let error = part.data().unwrap_err().to_string();
    assert!(error.contains("vertex 5 is moved") && error.contains("5 vertices"), "{error}");
    let broken = MeshPart::new("a.obj", b"f 1 2 3\n".to_vec());
    let error = broken.data().unwrap_err().to_string();
    assert!(error.contains("mesh.bytes, a.obj: "), "{error}");
}

/// Files may be gzipped, with a byte order mark or without, and hold a model.
#[test]
fn projects_are_read_in_every_wrapping() {
    use std::io::Write as _;
    let model = br#"{"tangents": [[[1, 0, 0]], [[1, 0, 0]]], "lengths": [1, 1], "t": [0, 1],
        "initial": {"type": "polyline", "points": [[0, 0, 0], [0, 1, 0]], "t": [0, 1]}}"#;
    let model: Value = serde_json::from_slice(model).unwrap();
    let project = Project {
        workspace: Workspace::Streamline,
        model: Some(model),
        mesh: Some(MeshPart::new("a.obj", b"v 0 0 0\n".to_vec())),
        studio: json!({"theme": "dark", "views": [1, {"a": null}]}),
        ..Project::default()
    };
    let bytes = encode(&project);
    let mut gzip = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    gzip.write_all(&bytes).unwrap();
    assert_eq!(parse(&gzip.finish().unwrap()).unwrap(), project);
    assert_eq!(parse(&[b"\xef\xbb\xbf", &bytes[..]].concat()).unwrap(), project);
    let data = project.mesh.unwrap().data().unwrap();
    assert_eq!(data.positions.len(), 1);
    assert_eq!(Format::from_path("a.obj".as_ref()), Some((Format::Obj, false)));
}
