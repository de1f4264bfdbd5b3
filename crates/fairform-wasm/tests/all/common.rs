//! Fixtures and meshes as files.

use fairform::{Faces, Mesh, Vec3};
use fairform_io::project::Design;
use fairform_io::{Format, MeshData, WriteOptions, encode, parse};
use fairform_wasm::{MeshSession, What};
use serde_json::Value;

pub fn data(path: &str) -> Vec<u8> {
    let path = format!("{}/../../data/{path}", env!("CARGO_MANIFEST_DIR"));
    std::fs::read(&path).unwrap_or_else(|e| panic!("{path}: {e}"))
}

/// The names of the files in a folder of `data`.
pub fn names(folder: &str) -> Vec<String> {
    let path = format!("{}/../../data/{folder}", env!("CARGO_MANIFEST_DIR"));
    let entries = std::fs::read_dir(&path).unwrap_or_else(|e| panic!("{path}: {e}"));
    let mut names: Vec<String> =
        entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

pub fn points(value: &Value) -> Vec<Vec3> {
    let number = |v: &Value| v.as_f64().unwrap();
    let list = value.as_array().unwrap();
    list.iter().map(|p| Vec3::new(number(&p[0]), number(&p[1]), number(&p[2]))).collect()
}

pub fn obj(positions: Vec<Vec3>, faces: Faces) -> Vec<u8> {
    let data = MeshData { positions, faces, ..MeshData::default() };
    let mut out = Vec::new();
    encode(Format::Obj, &data, &WriteOptions::default(), &mut out).unwrap();
    out
}

pub fn open(mesh: &Mesh) -> MeshSession {
    let bytes = obj(mesh.positions().to_vec(), mesh.topology().to_faces());
    MeshSession::open::<&str>(&bytes, "mesh.obj", &[]).unwrap()
}

/// What a session saves, in full precision.
pub fn saved(session: &MeshSession, what: What) -> MeshData {
    parse(&session.save(what, Format::Obj).unwrap(), Format::Obj).unwrap()
}

pub fn fit(session: &mut MeshSession, design: &Design) -> fairform_wasm::FitResult {
    session.fit(design, &mut |_| std::ops::ControlFlow::Continue(())).unwrap()
}

/// Largest distance of points from others.
pub fn distance(a: &[Vec3], b: &[Vec3]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(p, q)| (*p - *q).length()).fold(0.0, f64::max)
}
