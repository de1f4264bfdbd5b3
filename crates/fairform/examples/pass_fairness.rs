//! How fair are exact fits after so few steps of the solve? Prints the ratios of `∫ H²` and `∫ |∇H|²` to
//! those of the fully converged surface, as Markdown:
//! `cargo run --release --example pass_fairness -- data/meshes/quad/*.obj`.

use fairform::interpolate::{Options, interpolate};
use fairform::onepass::{self, OnePass};
use fairform::refine::{refine, refine_mesh};
use fairform::{Faces, Mesh, Rules, Scheme, Vec3, fairness, limit, shapes};
use std::sync::Arc;

const STEPS: [u32; 5] = [0, 2, 4, 6, 8];

fn main() {
    println!("| mesh | scheme | {} |", STEPS.map(|m| format!("m = {m}")).join(" | "));
    println!("|---|---|{}", "---|".repeat(STEPS.len()));
    let ball = |levels| {
        let ball = refine_mesh(&shapes::icosahedron(), &Rules::LOOP, levels).expect("triangles").0;
        ball.with_positions(ball.positions().iter().map(|p| p.normalized()).collect())
    };
    let mut meshes = vec![
        ("sphere".to_string(), ball(2)),
        ("sphere, noise".to_string(), shaken(&ball(3), 0.01)),
        ("torus, noise".to_string(), shaken(&shapes::torus(24, 36), 0.01)),
    ];
    meshes.extend(std::env::args().skip(1).map(|path| (path.clone(), obj(&path))));
    for (name, mesh) in meshes {
        let faces = mesh.topology().face_count();
        let two_phase = |lambda: f64| Rules {
            tension: Some(Arc::from(vec![lambda; faces])),
            ..Scheme::DooSabin.into()
        };
        let all = [
            ("Loop", Rules::LOOP),
            ("Catmull–Clark", Scheme::CatmullClark.into()),
            ("Doo–Sabin λ = 0.5", two_phase(0.5)),
            ("Doo–Sabin λ = 0.8", two_phase(0.8)),
        ];
        for (scheme, rules) in all {
            if let Some(cells) = row(&mesh, &rules) {
                let name = name.rsplit('/').next().unwrap_or_default();
                println!("| {name} | {scheme} | {} |", cells.join(" | "));
            }
        }
    }
}

/// `None` if the scheme is not for the mesh, or nothing converges.
fn row(mesh: &Mesh, rules: &Rules) -> Option<Vec<String>> {
    let options = Options { tolerance: Some(1e-10), ..Options::default() };
    let (control, report) = interpolate(mesh, rules, &options).ok()?;
    if !report.is_converged() {
        return None;
    }
    let step = refine(mesh.topology(), rules).ok()?;
    let (next, finer) = (step.next.clone(), step.topology.clone());
    let converged =
        energies(&Mesh::from_parts(finer.into(), step.apply(control.positions())), &next);
    let cells = STEPS.map(|steps| {
        let options = onepass::Options { steps: Some(steps), ..onepass::Options::default() };
        let pass = OnePass::new(mesh.topology(), rules, &options).expect("as before");
        let (values, _) = pass.fit(mesh.positions()).expect("as before");
        let [bending, variation] =
            energies(&Mesh::from_parts(step.topology.clone().into(), values), &next);
        format!("{:.3} / {:.2}", bending / converged[0], variation / converged[1])
    });
    Some(cells.to_vec())
}

fn energies(control: &Mesh, rules: &Rules) -> [f64; 2] {
    let (fine, rules) = refine_mesh(control, rules, 2).expect("not too large");
    let (topology, points) = (fine.topology(), fine.positions());
    let positions = limit::limit_points(topology, points, &rules).expect("a limit");
    let normals = limit::limit_normals(topology, points, &rules).expect("a limit");
    let curvatures = fairness::curvatures(topology, &positions, &normals);
    let measures = fairness::measures(topology, &positions, &curvatures);
    [measures.willmore, measures.mean_variation]
}

fn shaken(mesh: &Mesh, size: f64) -> Mesh {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut random = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        size * ((state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0)
    };
    let shake = |&p: &Vec3| p + Vec3::new(random(), random(), random());
    mesh.with_positions(mesh.positions().iter().map(shake).collect())
}

/// Vertices and faces of an OBJ file, nothing else.
fn obj(path: &str) -> Mesh {
    let text = std::fs::read_to_string(path).expect("a readable file");
    let (mut points, mut faces) = (Vec::new(), Faces::new());
    for line in text.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let mut number = || words.next().and_then(|w| w.parse().ok()).expect("a number");
                points.push(Vec3::new(number(), number(), number()));
            }
            Some("f") => {
                let index = |w: &str| w.split('/').next().and_then(|i| i.parse::<u32>().ok());
                let face: Vec<u32> = words.map(|w| index(w).expect("an index") - 1).collect();
                faces.push(&face);
            }
            _ => {}
        }
    }
    Mesh::new(points, &faces).expect("a manifold")
}
