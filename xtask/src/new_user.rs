//! The main job, as someone does it who has just got the command: in a folder with nothing in it.

use std::fs;
use std::path::{Path, PathBuf};

use crate::command::{Result, fairform, step};

/// Vertices of an octahedron; the surface has to pass through them.
const CORNERS: [[f64; 3]; 6] = [
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [-1.0, 0.0, 0.0],
    [0.0, -1.0, 0.0],
    [0.0, 0.0, -1.0],
];

const FACES: &str = "\
f 1 2 3\nf 2 4 3\nf 4 5 3\nf 5 1 3\nf 2 1 6\nf 4 2 6\nf 5 4 6\nf 1 5 6\n";

pub(crate) fn run() -> Result {
    let place = Scratch::new()?;
    sample(&place.0)?;
    own_mesh(&place.0)
}

/// `fairform fit` alone leaves a surface and a picture.
fn sample(place: &Path) -> Result {
    step("a new user: fairform fit", &mut fairform("dev", place, &["fit"]))?;
    let surface = read(&place.join("fairform-sample.ply"))?;
    let header = surface.get(..2048.min(surface.len())).unwrap_or_default();
    let header = String::from_utf8_lossy(header);
    let count = header
        .lines()
        .find_map(|line| line.strip_prefix("element vertex "))
        .and_then(|count| count.trim().parse::<usize>().ok())
        .ok_or("fairform-sample.ply has no header of a PLY file")?;
    // A vertex has three coordinates of four bytes at least.
    ensure(count > 1000 && surface.len() > 12 * count, "fairform-sample.ply is cut off")?;
    let picture = read(&place.join("fairform-sample.png"))?;
    ensure(
        picture.starts_with(b"\x89PNG\r\n\x1a\n") && picture.ends_with(b"IEND\xaeB`\x82"),
        "fairform-sample.png is no whole PNG file",
    )
}

/// A surface through the vertices of a file passes through them, and vertex i stays vertex i.
fn own_mesh(place: &Path) -> Result {
    let vertices = CORNERS.map(|[x, y, z]| format!("v {x} {y} {z}\n")).concat();
    write(&place.join("octahedron.obj"), &(vertices + FACES))?;
    let args = ["fit", "octahedron.obj", "-o", "surface.obj", "--levels", "3", "--limit"];
    step(
        "a new user: fairform fit octahedron.obj -o surface.obj",
        &mut fairform("dev", place, &args),
    )?;
    let surface = read(&place.join("surface.obj"))?;
    let surface = String::from_utf8(surface).map_err(|_| "surface.obj is no text")?;
    let vertices: Vec<Vec<f64>> = surface
        .lines()
        .filter_map(|line| line.strip_prefix("v "))
        .map(|line| line.split_whitespace().filter_map(|word| word.parse().ok()).collect())
        .collect();
    let face_count = surface.lines().filter(|line| line.starts_with("f ")).count();
    ensure(vertices.len() == 258 && face_count == 512, "surface.obj has the wrong size")?;
    for (vertex, corner) in vertices.iter().zip(CORNERS) {
        let is_near =
            vertex.len() >= 3 && vertex.iter().zip(corner).all(|(a, b)| (a - b).abs() < 3e-6);
        ensure(is_near, &format!("surface.obj misses the vertex {corner:?}: it has {vertex:?}"))?;
    }
    Ok(())
}

fn ensure(holds: bool, otherwise: &str) -> Result {
    if holds { Ok(()) } else { Err(otherwise.into()) }
}

fn read(path: &Path) -> Result<Vec<u8>> {
    fs::read(path).map_err(|e| format!("{}: {e}", path.display()))
}

fn write(path: &Path, text: &str) -> Result {
    fs::write(path, text).map_err(|e| format!("{}: {e}", path.display()))
}

/// An empty folder, removed afterwards.
struct Scratch(PathBuf);

impl Scratch {
    fn new() -> Result<Self> {
        let place = std::env::temp_dir().join(format!("fairform-new-user-{}", std::process::id()));
        fs::create_dir(&place).map_err(|e| format!("{}: {e}", place.display()))?;
        Ok(Self(place))
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        // What is left behind in a folder for temporary files does no harm.
        let _ = fs::remove_dir_all(&self.0);
    }
}
