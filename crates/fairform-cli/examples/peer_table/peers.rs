//! The programs that are compared, and what one of them says.

use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use crate::{Case, Work};

/// A program and one way to use it.
pub(crate) struct Peer {
    /// Name in the tables; `{}` stands for library and version, which the program tells.
    pub(crate) label: String,
    program: PathBuf,
    /// Arguments before and after those that all have.
    before: Vec<String>,
    after: Vec<&'static str>,
    schemes: &'static [&'static str],
    work: Work,
}

const LOOP: &[&str] = &["loop"];
const TWO: &[&str] = &["loop", "catmull-clark"];
const THREE: &[&str] = &["loop", "catmull-clark", "doo-sabin"];

/// Programs in C++: label, name, last argument, schemes, work.
const PROGRAMS: [(&str, &str, &str, &[&str], Work); 15] = [
    ("{}, level by level", "opensubdiv", "primvar", TWO, Work::Refine),
    ("{}, level by level, f64", "opensubdiv", "primvar64", TWO, Work::Refine),
    ("{}, stencils", "opensubdiv", "stencils", TWO, Work::Refine),
    ("{}, stencils, f64", "opensubdiv", "stencils64", TWO, Work::Refine),
    ("{}", "cgal", "", THREE, Work::Refine),
    ("{}, f32", "openmesh", "32", TWO, Work::Refine),
    ("{}", "openmesh", "", TWO, Work::Refine),
    ("{}, level by level", "opensubdiv", "limit", TWO, Work::Limit),
    ("{}, level by level, f64", "opensubdiv", "limit64", TWO, Work::Limit),
    ("{}, limit stencils", "opensubdiv", "places", TWO, Work::Limit),
    ("{}, limit stencils, f64", "opensubdiv", "places64", TWO, Work::Limit),
    ("{}", "cholmod", "", LOOP, Work::Fit),
    ("{}, simplicial", "cholmod", "simplicial", LOOP, Work::Fit),
    ("{}, supernodal", "cholmod", "supernodal", LOOP, Work::Fit),
    ("{}, supernodal, METIS", "cholmod", "metis", LOOP, Work::Fit),
];

/// Libraries that `peers.py` knows.
const PYTHON: [&str; 4] = ["vtk", "igl", "trimesh", "open3d"];

/// Ourselves first; then the others that are installed, and the names of those that are not.
pub(crate) fn all(root: &Path) -> (Vec<Peer>, Vec<&'static str>) {
    let mut present = ours();
    let mut absent = Vec::new();
    let bin = root.join("target/peers/bin");
    for (label, name, after, schemes, work) in PROGRAMS {
        let program = bin.join(name);
        if !program.is_file() {
            // The ways to use a library do not all stand together.
            if !absent.contains(&name) {
                absent.push(name);
            }
            continue;
        }
        let after = if after.is_empty() { vec![] } else { vec![after] };
        present.push(Peer { label: label.into(), program, before: vec![], after, schemes, work });
    }
    let own = root.join("target/peers/venv/bin/python");
    let python = if own.is_file() { own } else { PathBuf::from("python3") };
    let script = root.join("benches/peers/peers.py").to_string_lossy().into_owned();
    for library in PYTHON {
        let has = Command::new(&python).args([&script, "--has", library]).output();
        if !has.is_ok_and(|has| has.status.success()) {
            absent.push(library);
            continue;
        }
        present.push(Peer {
            label: "{} (Python)".into(),
            program: python.clone(),
            before: vec![script.clone(), library.into()],
            after: vec![],
            schemes: LOOP,
            work: Work::Refine,
        });
    }
    (present, absent)
}

/// fairform in all its ways. The first one of each kind of work is what the others are compared with.
fn ours() -> Vec<Peer> {
    let program = std::env::current_exe().expect("this program has a path");
    let one = |label: &str, after: &[&'static str], schemes, work| Peer {
        label: label.into(),
        program: program.clone(),
        before: vec!["ours".into()],
        after: after.to_vec(),
        schemes,
        work,
    };
    vec![
        one("**fairform**, 1 thread", &["1"], THREE, Work::Refine),
        one("**fairform**, 2 threads", &["2"], THREE, Work::Refine),
        one("**fairform**, 1 thread, f32", &["1", "f32"], THREE, Work::Refine),
        one("**fairform**, 1 thread, step by step", &["1", "steps"], THREE, Work::Refine),
        one("**fairform**, 1 thread", &["1", "limit"], TWO, Work::Limit),
        one("**fairform**, 2 threads", &["2", "limit"], TWO, Work::Limit),
        one("**fairform**, 1 thread, f32", &["1", "limit-f32"], TWO, Work::Limit),
        one("**fairform**, 1 thread", &["1", "fit"], LOOP, Work::Fit),
        one("**fairform**, 2 threads", &["2", "fit"], LOOP, Work::Fit),
        one("**fairform** to 1e-12, 1 thread", &["1", "fit-12"], LOOP, Work::Fit),
        one("**fairform**, exact on level 1, 1 thread", &["1", "exact"], LOOP, Work::Fit),
        #[cfg(feature = "direct")]
        one("**fairform** with faer, simplicial", &["1", "direct"], LOOP, Work::Fit),
    ]
}

impl Peer {
    /// What it is called where its library has not told its name: the program and how it is used.
    pub(crate) fn id(&self) -> String {
        let program = self.program.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let own = self.before.last().filter(|_| !self.is_ours()).cloned().unwrap_or(program);
        [own.as_str()].iter().chain(&self.after).copied().collect::<Vec<_>>().join(" ")
    }

    /// Whether it is fairform.
    pub(crate) fn is_ours(&self) -> bool {
        self.before.first().is_some_and(|first| first == "ours")
    }

    pub(crate) fn does(&self, scheme: &str, work: Work) -> bool {
        self.work == work && self.schemes.contains(&scheme)
    }

    /// Runs it once; what went wrong otherwise, in a line.
    pub(crate) fn run(&self, case: &Case<'_>, repeats: usize) -> Result<Run, String> {
        let output = Command::new(&self.program)
            .args(&self.before)
            .arg(&case.subject.path)
            .args([case.scheme, &case.levels.to_string(), &repeats.to_string()])
            .args(&self.after)
            // The others are compared on one thread.
            .envs([("OMP_NUM_THREADS", "1"), ("OPENBLAS_NUM_THREADS", "1")])
            .output()
            .map_err(|e| e.to_string())?;
        if !output.status.success() {
            let said = String::from_utf8_lossy(&output.stderr);
            return Err(said.lines().last().unwrap_or("fails without a word").into());
        }
        let text = String::from_utf8_lossy(&output.stdout);
        let line = text.lines().last().unwrap_or_default();
        Run::parse(line).ok_or_else(|| format!("says: {line}"))
    }
}

/// What tells two results apart without all their numbers.
pub(crate) struct Summary {
    pub(crate) vertices: u64,
    pub(crate) faces: u64,
    /// Mean of the points, their smallest and largest coordinates.
    pub(crate) triples: [[f64; 3]; 3],
    /// Mean square of the distances from the origin.
    pub(crate) square: f64,
}

/// What a program says in the end.
pub(crate) struct Run {
    pub(crate) library: String,
    pub(crate) summary: Summary,
    /// Seconds to build the library's structure, refine it, and copy the result out.
    pub(crate) samples: Vec<[f64; 3]>,
    /// Seconds that all threads ran, for each sample.
    pub(crate) cpu: Vec<f64>,
    /// Peak of memory above what the process had with the mesh read.
    pub(crate) bytes: f64,
}

impl Run {
    fn parse(line: &str) -> Option<Self> {
        let value: Value = serde_json::from_str(line).ok()?;
        let numbers = |value: &Value| -> Option<Vec<f64>> {
            value.as_array()?.iter().map(Value::as_f64).collect()
        };
        let triple = |value: &Value| -> Option<[f64; 3]> { numbers(value)?.try_into().ok() };
        Some(Self {
            library: value["library"].as_str()?.into(),
            summary: Summary {
                vertices: value["vertices"].as_u64()?,
                faces: value["faces"].as_u64()?,
                triples: [triple(&value["mean"])?, triple(&value["min"])?, triple(&value["max"])?],
                square: numbers(&value["square"])?.first().copied()?,
            },
            samples: value["samples"].as_array()?.iter().map(triple).collect::<Option<_>>()?,
            cpu: numbers(&value["cpu"])?,
            bytes: value["bytes"].as_f64()?,
        })
    }

    /// Seconds of the best sample.
    pub(crate) fn best(&self) -> f64 {
        self.samples.iter().map(|parts| parts.iter().sum()).fold(f64::INFINITY, f64::min)
    }
}

impl Summary {
    /// The largest difference to `other`, as a part of its diagonal; `None` if the counts differ.
    pub(crate) fn difference(&self, other: &Self) -> Option<f64> {
        if (self.vertices, self.faces) != (other.vertices, other.faces) {
            return None;
        }
        let [_, min, max] = other.triples;
        let diagonal = min.iter().zip(max).map(|(a, b)| (b - a) * (b - a)).sum::<f64>().sqrt();
        let all = self.triples.as_flattened().iter().zip(other.triples.as_flattened());
        let largest = all.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        Some(largest.max((self.square.sqrt() - other.square.sqrt()).abs()) / diagonal)
    }
}
