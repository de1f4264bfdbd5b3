//! `fairform compare`.

use std::fmt::Write as _;
use std::ops::ControlFlow;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

use fairform::fairness::{self, Measures};
use fairform::interpolate::{self, Options};
use fairform::repair::Soup;
use fairform::{Faces, Mesh, Rules, Scheme, Vec3, VertexId, limit, refine, tension};
use fairform_render::{Body, Line, Panel};
use serde_json::{Value, json};

use crate::args::Compare;
use crate::console::Console;
use crate::failure::Failure;
use crate::input::{self, Source};
use crate::surface::{Stored, Surface, check_memory};

pub(crate) fn run(args: &Compare, console: &Console) -> Result<ExitCode, Failure> {
    if let Some(path) = &args.output {
        super::render::check_picture(path)?;
        input::check_outputs(&[path], console)?;
    }
    let source = Source::from(&args.input);
    let mut target = Surface::new(input::read(&source, console)?, &source)?;
    // The largest of the results.
    target.rules = Scheme::CatmullClark.into();
    check_memory(&target, args.levels, Stored::Steps, &source)?;
    let mesh = &target.mesh;
    let progress = console.progress();
    let mut rows = Vec::new();
    for (name, rules, shape) in schemes(mesh) {
        progress.say(format!("fitting: {name}"));
        let row =
            shape.of(mesh).and_then(|own| Row::new(name, mesh, &own, &rules, shape, args.levels));
        match row {
            Ok(row) => rows.push(row),
            Err(error) => console.note(format!("note: {name} left out: {error}")),
        }
    }
    if let Some(path) = &args.output {
        progress.say("drawing");
        input::save(path, &picture(mesh, &rows, args)?)?;
    }
    drop(progress);
    if console.json() {
        let rows: Vec<Value> = rows.iter().map(Row::json).collect();
        console.result(&json!({ "file": source.to_string(), "schemes": rows }))?;
    } else {
        console.print(&table(&rows))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// What is done to a mesh before a scheme can take it. Its vertices stay, and are interpolated.
#[derive(Clone, Copy, PartialEq)]
enum Shape {
    AsGiven,
    /// Polygons are cut into triangles.
    Triangles,
    /// Polygons are cut into quadrilaterals at the middles of edges and faces, by a step of Catmull–Clark's
    /// connectivity.
    Quadrilaterals,
}

impl Shape {
    fn name(self) -> &'static str {
        match self {
            Self::AsGiven => "as given",
            Self::Triangles => "triangulated",
            Self::Quadrilaterals => "split",
        }
    }

    fn of(self, mesh: &Mesh) -> Result<Mesh, fairform::Error> {
        match self {
            Self::AsGiven => Ok(mesh.clone()),
            Self::Triangles => {
                let faces = mesh.topology().to_faces();
                let mut soup = Soup::new(mesh.positions().to_vec(), faces);
                let _ = soup.triangulate();
                Mesh::new(soup.positions, &soup.faces)
            }
            Self::Quadrilaterals => {
                let (topology, p) = (mesh.topology(), mesh.positions());
                let finer = refine::refine(topology, &Scheme::CatmullClark.into())?.topology;
                let at = |v: VertexId| p[v.index()];
                let mut positions = p.to_vec();
                positions.extend(topology.edges().map(|e| {
                    let h = topology.edge_halfedge(e);
                    0.5 * (at(topology.origin(h)) + at(topology.target(h)))
                }));
                positions.extend(topology.faces().map(|f| {
                    let corners = topology.face_vertices(f);
                    corners.iter().map(|&v| at(v)).sum::<Vec3>() / corners.len() as f64
                }));
                Ok(Mesh::from_parts(Arc::new(finer), positions))
            }
        }
    }
}

/// All schemes, and what they need.
fn schemes(mesh: &Mesh) -> Vec<(&'static str, Rules, Shape)> {
    let size = mesh.topology().uniform_face_size();
    let tight =
        |scheme: Scheme, lambda: Vec<f64>| Rules { tension: Some(lambda.into()), ..scheme.into() };
    let count = mesh.topology().face_count();
    let triangles = if size == Some(3) { Shape::AsGiven } else { Shape::Triangles };
    let quadrilaterals = if size == Some(4) { Shape::AsGiven } else { Shape::Quadrilaterals };
    let triangle_count: usize =
        mesh.topology().faces().map(|f| mesh.topology().face_halfedges(f).len() - 2).sum();
    vec![
        ("loop", Rules::LOOP, triangles),
        ("loop, 0.75", tight(Scheme::Loop, vec![0.75; triangle_count]), triangles),
        ("catmull-clark", Scheme::CatmullClark.into(), Shape::AsGiven),
        ("catmull-clark, 0.75", tight(Scheme::CatmullClark, vec![0.75; count]), Shape::AsGiven),
        ("doo-sabin", Scheme::DooSabin.into(), Shape::AsGiven),
        ("doo-sabin, auto", tight(Scheme::DooSabin, tension::automatic(mesh)), Shape::AsGiven),
        ("doo-sabin, 0.5", tight(Scheme::DooSabin, vec![0.5; count]), Shape::AsGiven),
        ("doo-sabin, 0.85", tight(Scheme::DooSabin, vec![0.85; count]), Shape::AsGiven),
        ("butterfly", Scheme::Butterfly.into(), triangles),
        ("kobbelt", Scheme::Kobbelt.into(), quadrilaterals),
    ]
}

/// What one scheme makes of the mesh.
struct Row {
    name: &'static str,
    shape: Shape,
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    faces: Faces,
    error: f64,
    seconds: f64,
    measures: Measures,
    deviation: f64,
    undulation: Option<f64>,
}

impl Row {
    /// Fits `own`, which is `target` in another shape; measured against `target`, at about the same number
    /// of faces.
    fn new(
        name: &'static str,
        target: &Mesh,
        own: &Mesh,
        rules: &Rules,
        shape: Shape,
        levels: u32,
    ) -> Result<Self, fairform::Error> {
        let levels = levels.saturating_sub(u32::from(shape == Shape::Quadrilaterals));
        let start = Instant::now();
        let mut go_on = |_, _| ControlFlow::Continue(());
        let fit = interpolate::fit_mesh(own, rules, &Options::default(), &mut go_on)?;
        let seconds = start.elapsed().as_secs_f64();
        let (fine, rules) =
            refine::refine_mesh(&fit.control, &fit.rules, levels.saturating_sub(fit.level))?;
        let (topology, control) = (fine.topology(), fine.positions());
        let positions = limit::limit_points(topology, control, &rules)?;
        let normals = limit::limit_normals(topology, control, &rules)?;
        let curvatures = fairness::curvatures(topology, &positions, &normals);
        let measures = fairness::measures(topology, &positions, &curvatures);
        let undulation = fairness::undulation(&measures, target).ratio();
        let deviation = fairness::deviation(&positions, target).max / target.bounds().diagonal();
        let faces = topology.to_faces();
        let error = fit.report.max;
        Ok(Self {
            name,
            shape,
            positions,
            normals,
            faces,
            error,
            seconds,
            measures,
            deviation,
            undulation,
        })
    }

    fn json(&self) -> Value {
        json!({
            "scheme": self.name,
            "mesh": self.shape.name(),
            "error": self.error,
            "bending_energy": self.measures.bending,
            "curvature_variation": self.measures.relative_mean_variation(),
            "deviation": self.deviation,
            "undulation": self.undulation,
            "seconds": self.seconds,
        })
    }
}

fn table(rows: &[Row]) -> String {
    let mut text = format!(
        "{:<22} {:>9} {:>10} {:>12} {:>10} {:>10} {:>9}\n",
        "scheme", "error", "bending", "variation", "deviation", "undulation", "seconds"
    );
    for row in rows {
        let undulation = row.undulation.map_or("–".into(), |u| format!("{u:.3}"));
        let _ = writeln!(
            text,
            "{:<22} {:>9.1e} {:>10.4} {:>12.4e} {:>10.5} {:>10} {:>9.4}",
            format!("{}{}", row.name, mark(row.shape)),
            row.error,
            row.measures.bending,
            row.measures.relative_mean_variation(),
            row.deviation,
            undulation,
            row.seconds
        );
    }
    text.push_str(
        "\nerror: largest distance of a vertex from the surface, by the diagonal; bending: ∫ k1² + k2²; \
         variation: of the\nmean curvature, without unit; deviation: of the surface from the mesh, by the \
         diagonal; undulation: turning of\nthe surface over that of the mesh, about 1 if it does not wave; \
         seconds: of the fit\n",
    );
    for shape in [Shape::Triangles, Shape::Quadrilaterals] {
        if rows.iter().any(|row| row.shape == shape) {
            let what = match shape {
                Shape::Triangles => "of the mesh with its polygons cut into triangles",
                _ => "of the mesh with its polygons cut once, flat, into quadrilaterals",
            };
            let _ =
                writeln!(text, "{} {what}; measured against the mesh as given", mark(shape).trim());
        }
    }
    text
}

fn mark(shape: Shape) -> &'static str {
    match shape {
        Shape::AsGiven => "",
        Shape::Triangles => " *",
        Shape::Quadrilaterals => " **",
    }
}

fn picture(target: &Mesh, rows: &[Row], args: &Compare) -> Result<Vec<u8>, Failure> {
    let faces = target.topology().to_faces();
    let mut given = Body::new(target.positions(), &faces);
    given.style.smooth = false;
    given.style.wireframe = Some(Line::default());
    let mut panels = vec![Panel { bodies: vec![given], title: Some("the mesh".into()) }];
    for row in rows {
        let mut body = Body::new(&row.positions, &row.faces);
        body.normals = Some(&row.normals);
        let title = format!("{}\nbending {:.3}", row.name, row.measures.bending);
        panels.push(Panel { bodies: vec![body], title: Some(title) });
    }
    let options = fairform_render::Options::default();
    Ok(fairform_render::render(&panels, &args.view, args.size, &options)?.to_png())
}
