//! Running the command in a folder of its own.

#![allow(dead_code, reason = "every test file uses some of it")]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use fairform::Vec3;
use fairform_io::MeshData;
use serde_json::Value;
use tempfile::TempDir;

/// The cases of `data/golden/loop`.
pub const GOLDEN_LOOP: [&str; 11] = [
    "boundary-fan-2",
    "boundary-fan-5",
    "cube-triangulated",
    "icosahedron",
    "noisy-sphere",
    "octahedron",
    "open-cylinder",
    "open-grid",
    "single-triangle",
    "six-configurations",
    "tetrahedron",
];

pub fn data(path: &str) -> PathBuf {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../data")).join(path)
}

pub fn golden(name: &str) -> Value {
    let path = data(&format!("golden/loop/{name}.json"));
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

/// How a run of the command ended.
#[derive(Debug)]
pub struct Run {
    pub code: Option<i32>,
    pub stdout: Vec<u8>,
    pub stderr: String,
}

impl From<Output> for Run {
    fn from(output: Output) -> Self {
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert!(!stderr.contains("panicked"), "{stderr}");
        Self { code: output.status.code(), stdout: output.stdout, stderr }
    }
}

impl Run {
    pub fn json(&self) -> Value {
        serde_json::from_slice(&self.stdout).unwrap()
    }
}

/// A folder that goes when the test ends, in which the command runs.
pub struct Folder(TempDir);

impl Folder {
    pub fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn write(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).unwrap();
    }

    pub fn bytes(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    pub fn mesh(&self, name: &str) -> MeshData {
        fairform_io::read(&self.path(name), None).unwrap()
    }

    pub fn json(&self, name: &str) -> Value {
        serde_json::from_slice(&self.bytes(name)).unwrap()
    }

    /// The names of all files, sorted.
    pub fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.0.path()).unwrap();
        let name = |entry: std::io::Result<fs::DirEntry>| entry.unwrap().file_name();
        let mut names: Vec<_> = entries.map(|e| name(e).into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// The command with arguments separated by blanks.
    pub fn command(&self, arguments: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_fairform"));
        command.args(arguments.split_whitespace()).current_dir(self.0.path());
        command.stdin(Stdio::null());
        command
    }

    pub fn run(&self, arguments: &str) -> Run {
        self.command(arguments).output().unwrap().into()
    }

    /// The command, which succeeds.
    pub fn ok(&self, arguments: &str) -> Run {
        let run = self.run(arguments);
        assert_eq!(run.code, Some(0), "fairform {arguments}: {}", run.stderr);
        run
    }

    /// The command, which fails with a code and a message that contains `words`.
    pub fn fails(&self, arguments: &str, code: i32, words: &str) -> Run {
        let run = self.run(arguments);
        assert_eq!(run.code, Some(code), "fairform {arguments}: {}", run.stderr);
        assert!(run.stderr.contains("error: "), "fairform {arguments}: {}", run.stderr);
        assert!(run.stderr.contains(words), "no '{words}' in: {}", run.stderr);
        run
    }

    /// A line for a shell in which `fairform` is the command.
    #[cfg(unix)]
    pub fn shell(&self, line: &str) -> Run {
        let folder = Path::new(env!("CARGO_BIN_EXE_fairform")).parent().unwrap();
        let path = format!("{}:{}", folder.display(), std::env::var("PATH").unwrap());
        let mut shell = Command::new("sh");
        shell.args(["-c", line]).env("PATH", path).current_dir(self.0.path());
        shell.stdin(Stdio::null()).output().unwrap().into()
    }

    /// Saves a mesh of a golden file as OBJ.
    pub fn write_golden(&self, name: &str, mesh: &Value) {
        self.write(name, &obj(&points(&mesh["vertices"]), &faces(&mesh["faces"])));
    }
}

/// A mesh as OBJ text.
pub fn obj(points: &[Vec3], faces: &[Vec<u32>]) -> String {
    let mut text = String::new();
    for p in points {
        text += &format!("v {} {} {}\n", p.x, p.y, p.z);
    }
    for face in faces {
        text += "f";
        for v in face {
            text += &format!(" {}", v + 1);
        }
        text += "\n";
    }
    text
}

pub fn points(value: &Value) -> Vec<Vec3> {
    let lists: Vec<[f64; 3]> = serde_json::from_value(value.clone()).unwrap();
    lists.into_iter().map(Vec3::from).collect()
}

pub fn faces(value: &Value) -> Vec<Vec<u32>> {
    serde_json::from_value(value.clone()).unwrap()
}

pub fn face_lists(data: &MeshData) -> Vec<Vec<u32>> {
    data.faces.iter().map(<[u32]>::to_vec).collect()
}

#[track_caller]
pub fn assert_near(actual: &[Vec3], expected: &[Vec3], tolerance: f64, what: &str) {
    assert_eq!(actual.len(), expected.len(), "{what}");
    for (i, (a, e)) in actual.iter().zip(expected).enumerate() {
        let error = (*a - *e).length();
        assert!(error <= tolerance, "{what}: point {i} is off by {error:e}");
    }
}

/// The same mesh but for the numbers of vertices from `kept` on and the order of faces: each expected
/// vertex is one vertex within a tolerance, and the faces are the same, turned alike.
#[track_caller]
pub fn assert_same_mesh(
    actual: &MeshData,
    (vertices, faces): (&[Vec3], &[Vec<u32>]),
    kept: usize,
    tolerance: f64,
    what: &str,
) {
    assert_near(&actual.positions[..kept], &vertices[..kept], tolerance, what);
    assert_eq!(actual.positions.len(), vertices.len(), "{what}");
    let mut number = vec![u32::MAX; vertices.len()];
    for (i, p) in actual.positions.iter().enumerate() {
        let distance = |v: &usize| (vertices[*v] - *p).length();
        let nearest = (0..vertices.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)));
        let v = nearest.expect("as many vertices");
        assert!(distance(&v) <= tolerance, "{what}: point {i} is off by {:e}", distance(&v));
        assert_eq!(std::mem::replace(&mut number[v], i as u32), u32::MAX, "{what}: {v} twice");
    }
    let turned = |mut face: Vec<u32>| {
        let first = (0..face.len()).min_by_key(|&i| face[i]).unwrap_or(0);
        face.rotate_left(first);
        face
    };
    let mut actual: Vec<_> = face_lists(actual).into_iter().map(turned).collect();
    let renumbered = |face: &Vec<u32>| face.iter().map(|&v| number[v as usize]).collect();
    let mut expected: Vec<_> = faces.iter().map(renumbered).map(turned).collect();
    actual.sort();
    expected.sort();
    assert!(actual == expected, "{what}: faces");
}
