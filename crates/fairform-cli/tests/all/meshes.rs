//! Every mesh of `data/meshes`: it is fitted, or refused by name with advice that helps.

use std::fs;
use std::path::Path;

use crate::common::{Folder, assert_near, data, points};
use fairform::Mesh;
use fairform_io::MeshData;

/// What became of the files of a folder.
#[derive(Default, Debug, PartialEq)]
struct Tally {
    fitted: usize,
    advised: usize,
    refused: usize,
}

fn every_file_of(name: &str) -> Tally {
    let folder = Folder::new();
    let mut tally = Tally::default();
    let mut files: Vec<_> =
        fs::read_dir(data("meshes").join(name)).unwrap().map(|e| e.unwrap().path()).collect();
    files.sort();
    for file in files {
        let data = fairform_io::read(&file, None);
        let mesh = data.as_ref().ok().and_then(|d| Mesh::new(d.positions.clone(), &d.faces).ok());
        match mesh {
            Some(mesh) if is_ready(&mesh) => {
                is_fitted(&folder, &file, &mesh);
                tally.fitted += 1;
            }
            _ if is_advised(&folder, &file, data.ok().as_ref()) => tally.advised += 1,
            _ => tally.refused += 1,
        }
    }
    tally
}

/// Whether there is something, and all faces are triangles.
fn is_ready(mesh: &Mesh) -> bool {
    let topology = mesh.topology();
    topology.vertex_count() > 0 && topology.faces().all(|f| topology.face_vertices(f).len() == 3)
}

/// The limit points of the control mesh are the vertices of the file.
fn is_fitted(folder: &Folder, file: &Path, mesh: &Mesh) {
    let shown = file.display();
    folder.ok(&format!("fit {shown} -o control.obj --levels 0 --report report.json"));
    folder.ok("limit control.obj -o limit.json");
    let report = folder.json("report.json");
    assert_eq!(report["converged"], true, "{shown}");
    let limit = points(&folder.json("limit.json")["points"]);
    let tolerance = 1e-6 * mesh.bounds().diagonal() * (1.0 + 1e-6);
    assert_near(&limit, mesh.positions(), tolerance, &shown.to_string());
}

/// Refused with a message that names the file. Whether it advises a repair, which then helps.
fn is_advised(folder: &Folder, file: &Path, data: Option<&MeshData>) -> bool {
    let shown = file.display();
    let run = folder.fails(&format!("fit {shown} -o none.ply"), 1, &shown.to_string());
    assert!(!folder.path("none.ply").exists(), "{shown}");
    assert!(run.stderr.len() < 2000, "{shown}: {}", run.stderr);
    let advice = run.stderr.lines().find_map(|line| line.strip_prefix("help: "));
    let Some(advice) = advice else {
        let helpless = data.is_none_or(|d| {
            d.faces.is_empty() || !d.faces.iter().any(|f| f.len() > 2 && are_finite(d, f))
        });
        assert!(helpless, "{shown}: no advice in {}", run.stderr);
        return false;
    };
    #[cfg(unix)]
    {
        let repair = folder.shell(advice);
        assert_eq!(repair.code, Some(0), "{advice}: {}", repair.stderr);
        folder.ok("fit repaired.obj -o repaired.ply --levels 1");
        assert!(!folder.mesh("repaired.ply").faces.is_empty(), "{advice}");
    }
    true
}

fn are_finite(data: &MeshData, face: &[u32]) -> bool {
    face.iter().all(|&v| data.positions[v as usize].is_finite())
}

#[test]
fn closed_triangles() {
    assert_eq!(every_file_of("tri_closed"), Tally { fitted: 14, ..Tally::default() });
}

#[test]
fn open_triangles() {
    assert_eq!(every_file_of("tri_open"), Tally { fitted: 7, ..Tally::default() });
}

#[test]
fn quadrilaterals() {
    assert_eq!(every_file_of("quad"), Tally { advised: 15, ..Tally::default() });
}

#[test]
fn polygons() {
    assert_eq!(every_file_of("polygon"), Tally { advised: 7, ..Tally::default() });
}

#[test]
fn high_and_low_valences() {
    assert_eq!(every_file_of("valence"), Tally { fitted: 2, advised: 4, refused: 0 });
}

#[test]
fn odd_files() {
    assert_eq!(every_file_of("odd"), Tally { fitted: 34, advised: 38, refused: 0 });
}

#[test]
fn odd_files_from_elsewhere() {
    assert_eq!(every_file_of("odd_real"), Tally { advised: 8, ..Tally::default() });
}

#[test]
fn bad_files() {
    assert_eq!(every_file_of("bad"), Tally { fitted: 8, advised: 25, refused: 71 });
}

#[test]
fn bad_files_from_elsewhere() {
    assert_eq!(every_file_of("bad_real"), Tally { fitted: 1, advised: 13, refused: 4 });
}
