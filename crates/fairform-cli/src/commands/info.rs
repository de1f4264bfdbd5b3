//! `fairform info`.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;
use std::process::ExitCode;

use fairform::interpolate::{Interpolator, StageName};
use fairform::repair::Soup;
use fairform::{Bounds, Defect, Error, Faces, Mesh, Scheme, pushback};
use fairform_io::repair::{self, Steps, coincident};
use fairform_io::{MeshData, streamline};
use serde_json::{Value, json};

use crate::args::Info;
use crate::console::{Console, count};
use crate::failure::Failure;
use crate::input::{self, Source};
use crate::models::{self, short};
use crate::rules;
use crate::surface::Surface;

pub(crate) fn run(args: &Info, console: &Console) -> Result<ExitCode, Failure> {
    let source = Source::from(&args.input);
    if args.input.from.is_none() && is_json(&args.input.input) {
        return models(args, &source, console);
    }
    let data = input::read(&source, console)?;
    let judgement = match (args.scheme, args.rules.made()) {
        (Some(scheme), _) => Some(Judgement::new(scheme, args, &data, &source)?),
        (None, None) if !args.rules.tension.is_given() => None,
        (None, option) => {
            let option = option.unwrap_or("--lambda or --tension-where");
            return Err(
                Failure::usage(format!("{option} is for a scheme")).help("name it with --scheme")
            );
        }
    };
    let facts = Facts::new(data);
    if console.json() {
        let mut json = facts.json(&source);
        if let Some(judgement) = &judgement {
            json["scheme"] = judgement.json();
        }
        console.result(&json)?;
    } else {
        let mut text = facts.text(&source);
        if let Some(judgement) = &judgement {
            text += &judgement.text();
        }
        console.print(&text)?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Whether a name says JSON, packed or not.
fn is_json(path: &Path) -> bool {
    let packed = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("gz"));
    input::is_json(if packed { Path::new(path.file_stem().unwrap_or_default()) } else { path })
}

/// Says what is in a file of streamline models, or of a curve.
fn models(args: &Info, source: &Source, console: &Console) -> Result<ExitCode, Failure> {
    if args.scheme.is_some() {
        return Err(Failure::usage("--scheme is about meshes; a model names its own"));
    }
    let contents = streamline::read_any(&args.input.input)?;
    if console.json() {
        let mut json = models::contents_json(&contents);
        json["file"] = source.to_string().into();
        console.result(&json)?;
    } else {
        let mut text = format!("{source}\n");
        for (what, value) in models::contents_rows(&contents) {
            let _ = writeln!(text, "  {what:<12}{value}");
        }
        console.print(&text)?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Whether a scheme with its options can make a surface through the vertices of a mesh, and what is known
/// of it.
struct Judgement {
    scheme: Scheme,
    suits: bool,
    words: String,
    /// Lower bounds of the spectrum of the limit operator, by stage.
    stages: Vec<(StageName, usize, f64)>,
    /// Parts without a control mesh of their level.
    singular: usize,
    lambda: Option<[f64; 2]>,
    sharp_edges: usize,
    sharp_vertices: usize,
    /// Faces that are support only.
    support: usize,
    /// What the other commands would say.
    notes: Vec<String>,
}

impl Judgement {
    fn new(scheme: Scheme, args: &Info, data: &MeshData, source: &Source) -> Result<Self, Failure> {
        let mut judgement = Self {
            scheme,
            suits: false,
            words: String::new(),
            stages: vec![],
            singular: 0,
            lambda: None,
            sharp_edges: 0,
            sharp_vertices: 0,
            support: 0,
            notes: vec![],
        };
        if let Err(error) = Mesh::new(data.positions.clone(), &data.faces) {
            judgement.words = error.to_string();
            return Ok(judgement);
        }
        let mut surface = Surface::new(data.clone(), source)?;
        judgement.notes = rules::choose(scheme, &args.rules, &mut surface)?;
        let (topology, rules) = (surface.mesh.topology(), &surface.rules);
        match Interpolator::new(topology, rules) {
            Ok(interpolator) => judgement.stages = interpolator.stages().collect(),
            Err(error) => {
                judgement.words = error.to_string();
                return Ok(judgement);
            }
        }
        judgement.suits = true;
        judgement.singular = pushback::singular_components(topology, rules).len();
        judgement.words = match judgement.singular {
            0 if scheme.is_interpolating() => "suits, and keeps the vertices by itself".into(),
            0 if pushback::is_not_definite(topology, rules) => {
                "suits; fitted exactly at level 1, since with vertices of two faces no iteration \
                 converges"
                    .into()
            }
            0 => "suits".into(),
            1 => "suits; 1 part of valence 3 everywhere is fitted exactly at level 1".into(),
            n => format!(
                "suits; {} parts of valence 3 everywhere are fitted exactly at level 1",
                count(n)
            ),
        };
        judgement.lambda = rules.tension.as_ref().map(|tension| {
            let (low, high) = (f64::INFINITY, f64::NEG_INFINITY);
            tension.iter().fold([low, high], |[low, high], &x| [low.min(x), high.max(x)])
        });
        if let Some(creases) = &rules.creases {
            judgement.sharp_edges = topology.edges().filter(|&e| creases.edge(e) > 0.0).count();
            judgement.sharp_vertices =
                topology.vertices().filter(|&v| creases.vertex(v) > 0.0).count();
        }
        let shown = surface.shown.iter().flat_map(|shown| shown.iter());
        judgement.support = shown.filter(|shown| !**shown).count();
        Ok(judgement)
    }

    fn json(&self) -> Value {
        let stage = |&(name, vertices, bound): &(StageName, usize, f64)| json!({ "name": name.name(), "vertices": vertices, "smallest_eigenvalue": bound });
        json!({
            "name": self.scheme.name(),
            "suits": self.suits,
            "note": self.words,
            "stages": self.stages.iter().map(stage).collect::<Vec<_>>(),
            "singular_parts": self.singular,
            "lambda": self.lambda,
            "sharp_edges": self.sharp_edges,
            "sharp_vertices": self.sharp_vertices,
            "support_faces": self.support,
            "notes": self.notes,
        })
    }

    fn text(&self) -> String {
        let mut text = format!("  {}: {}\n", self.scheme, self.words);
        let mut row = |what: &str, value: String| {
            let _ = writeln!(text, "    {what:<10}{value}");
        };
        for &(name, vertices, bound) in &self.stages {
            let bound = match bound {
                _ if bound > 0.0 => {
                    format!("eigenvalues of the limit operator from {bound:.3} to 1")
                }
                0.0 => "eigenvalues of the limit operator from 0 to 1, no closer bound".into(),
                _ => "no bound for the eigenvalues of the limit operator".into(),
            };
            row(name.name(), format!("{} vertices, {bound}", count(vertices)));
        }
        if let Some([low, high]) = self.lambda {
            row("λ", format!("{} to {}", short(low), short(high)));
        }
        if self.sharp_edges + self.sharp_vertices > 0 {
            let (edges, vertices) = (count(self.sharp_edges), count(self.sharp_vertices));
            row("creases", format!("{edges} sharp edges, {vertices} sharp vertices"));
        }
        for note in &self.notes {
            let _ = writeln!(text, "    {note}");
        }
        text
    }
}

struct Facts {
    vertices: usize,
    /// How many faces there are of each number of corners.
    kinds: BTreeMap<usize, usize>,
    bounds: Bounds,
    /// Vertices at the position of an earlier one.
    coincident: usize,
    unused: usize,
    attributes: Vec<&'static str>,
    groups: Vec<String>,
    materials: Vec<String>,
    notes: Vec<String>,
    connectivity: Result<Connectivity, (Vec<Defect>, String)>,
    /// What makes the mesh fit for fitting, or better.
    remedy: Option<Steps>,
}

struct Connectivity {
    edges: usize,
    loops: usize,
    components: usize,
    genus: usize,
    valence: [u32; 2],
    triangles: bool,
    /// Closed parts that enclose a negative volume.
    inside_out: usize,
}

impl Facts {
    fn new(data: MeshData) -> Self {
        let sound = Mesh::new(data.positions.clone(), &data.faces);
        let remedy = match &sound {
            Ok(mesh) if mesh.topology().uniform_face_size() == Some(3) => repair::joining(mesh),
            _ => repair::remedy(&data.positions, &data.faces, true),
        };
        let mut kinds = BTreeMap::new();
        let mut used = vec![false; data.positions.len()];
        for face in data.faces.iter() {
            *kinds.entry(face.len()).or_default() += 1;
            for &v in face {
                if let Some(slot) = used.get_mut(v as usize) {
                    *slot = true;
                }
            }
        }
        let attributes = [
            ("normals", data.normals.is_some()),
            ("several normals of a vertex", data.corner_normals.is_some()),
            ("colours", data.colours.is_some()),
            ("texture coordinates", data.uvs.is_some()),
            ("texture coordinates with seams", data.corner_uvs.is_some()),
            ("crease tags", data.creases.is_some()),
        ];
        Self {
            vertices: data.positions.len(),
            kinds,
            bounds: Bounds::of(
                data.positions.iter().zip(&used).filter(|(_, used)| **used).map(|(&p, _)| p),
            ),
            coincident: coincident(&data.positions),
            unused: used.iter().filter(|used| !**used).count(),
            attributes: attributes.iter().filter(|a| a.1).map(|a| a.0).collect(),
            groups: data.groups.map_or(vec![], |l| l.names),
            materials: data.materials.map_or(vec![], |l| l.names),
            notes: data.notes,
            connectivity: match sound {
                Ok(mesh) => Ok(Connectivity::new(&mesh, &data.faces)),
                Err(error) => {
                    let message = error.to_string();
                    let defects = match error {
                        Error::NotManifold(defects) => defects.0,
                        _ => vec![],
                    };
                    Err((defects, message))
                }
            },
            remedy,
        }
    }

    fn faces(&self) -> usize {
        self.kinds.values().sum()
    }

    fn kinds(&self) -> String {
        if self.kinds.is_empty() {
            return "none".into();
        }
        let one = |(&corners, &n): (&usize, &usize)| {
            let plural = if n == 1 { "" } else { "s" };
            match corners {
                3 => format!("{} triangle{plural}", count(n)),
                4 => format!("{} quadrilateral{plural}", count(n)),
                _ => format!("{} {corners}-gon{plural}", count(n)),
            }
        };
        let shown: Vec<_> = self.kinds.iter().take(8).map(one).collect();
        let more = if self.kinds.len() > 8 { ", …" } else { "" };
        format!("{}{more}", shown.join(", "))
    }

    fn json(&self, source: &Source) -> Value {
        let sound = self.connectivity.as_ref().ok();
        let defects = self.connectivity.as_ref().err().map_or(&[][..], |e| &e.0);
        json!({
            "file": source.to_string(),
            "vertices": self.vertices,
            "faces": self.faces(),
            "kinds": self.kinds.iter().map(|(k, n)| (k.to_string(), json!(n)))
                .collect::<serde_json::Map<_, _>>(),
            "bounds": { "min": <[f64; 3]>::from(self.bounds.min), "max": <[f64; 3]>::from(self.bounds.max) },
            "coincident_vertices": self.coincident,
            "isolated_vertices": self.unused,
            "attributes": self.attributes,
            "groups": self.groups,
            "materials": self.materials,
            "notes": self.notes,
            "manifold": sound.is_some(),
            "edges": sound.map(|c| c.edges),
            "boundary_loops": sound.map(|c| c.loops),
            "components": sound.map(|c| c.components),
            "genus": sound.map(|c| c.genus),
            "valence": sound.map(|c| c.valence),
            "inside_out_parts": sound.map(|c| c.inside_out),
            "error": self.connectivity.as_ref().err().map(|e| &e.1),
            "help": self.remedy.as_ref().map(|steps| source.repair(steps)),
            "defects": tally(defects).into_iter().map(|(k, n)| (k.to_string(), json!(n)))
                .collect::<serde_json::Map<_, _>>(),
            "first_defects": defects.iter().take(20).map(ToString::to_string).collect::<Vec<_>>(),
        })
    }

    fn text(&self, source: &Source) -> String {
        let mut text = format!("{source}\n");
        let mut row = |what: &str, value: String| {
            let _ = writeln!(text, "  {what:<12}{value}");
        };
        row("vertices", count(self.vertices));
        row("faces", self.kinds());
        if !self.kinds.is_empty() {
            let (min, max) = (self.bounds.min, self.bounds.max);
            let sides = [("x", min.x, max.x), ("y", min.y, max.y), ("z", min.z, max.z)];
            let side = |(axis, from, to)| format!("{axis} {} to {}", short(from), short(to));
            row("box", sides.map(side).join(", "));
        }
        match &self.connectivity {
            Ok(_) if self.kinds.is_empty() => row("surface", "none, for want of faces".into()),
            Ok(c) => {
                row("edges", count(c.edges));
                row("parts", format!("{}, total genus {}", count(c.components), c.genus));
                row(
                    "boundary",
                    match c.loops {
                        0 => "none, the mesh is closed".into(),
                        1 => "1 loop".into(),
                        loops => format!("{} loops", count(loops)),
                    },
                );
                row("valence", format!("{} to {}", c.valence[0], c.valence[1]));
                let use_of = if c.triangles { "; ready for `fairform fit`" } else { "" };
                row("manifold", format!("yes{use_of}"));
                if c.inside_out > 0 {
                    row(
                        "inside out",
                        match c.inside_out {
                            1 => "1 part; `fairform repair --outward` turns it".into(),
                            parts => {
                                format!("{parts} parts; `fairform repair --outward` turns them")
                            }
                        },
                    );
                }
            }
            Err((defects, error)) => {
                row("manifold", "no".into());
                for (kind, n) in tally(defects) {
                    row("", format!("{} × {kind}", count(n)));
                }
                if defects.is_empty() {
                    row("", error.clone());
                }
                for defect in defects.iter().take(5) {
                    row("", format!("- {defect}"));
                }
                if defects.len() > 5 {
                    row("", "- …".into());
                }
                row("", "(vertices and faces are counted from 0)".into());
            }
        }
        if self.coincident > 0 {
            row("coincident", format!("{} at the place of another vertex", count(self.coincident)));
        }
        if self.unused > 0 {
            row("isolated", format!("{} without a face", count(self.unused)));
        }
        if !self.attributes.is_empty() {
            row("attributes", self.attributes.join(", "));
        }
        for (what, names) in [("groups", &self.groups), ("materials", &self.materials)] {
            if !names.is_empty() {
                let shown: Vec<_> = names.iter().take(8).map(|n| format!("{n:?}")).collect();
                let more = if names.len() > 8 { ", …" } else { "" };
                row(what, format!("{}: {}{more}", count(names.len()), shown.join(", ")));
            }
        }
        if let Some(steps) = &self.remedy {
            let ready = self.connectivity.as_ref().is_ok_and(|c| c.triangles);
            row(if ready { "to join" } else { "to fit it" }, source.repair(steps));
        }
        text
    }
}

impl Connectivity {
    fn new(mesh: &Mesh, faces: &Faces) -> Self {
        let topology = mesh.topology();
        let mut soup = Soup::new(mesh.positions().to_vec(), faces.clone());
        let components = topology.components().list;
        let valences = || {
            topology.vertices().filter(|&v| !topology.is_isolated(v)).map(|v| topology.valence(v))
        };
        Self {
            edges: topology.edge_count(),
            loops: topology.boundary_loops().len(),
            components: components.len(),
            genus: components.iter().map(fairform::topology::Component::genus).sum(),
            valence: [valences().min().unwrap_or(0), valences().max().unwrap_or(0)],
            triangles: topology.uniform_face_size() == Some(3),
            inside_out: soup.orient_outward().turned.count,
        }
    }
}

/// How many defects there are of each kind, in words.
fn tally(defects: &[Defect]) -> BTreeMap<&'static str, usize> {
    let mut tally = BTreeMap::new();
    for defect in defects {
        let kind = match defect {
            Defect::NotFinite { .. } => "vertex that is not finite",
            Defect::NoSuchVertex { .. } => "vertex number out of range",
            Defect::TooFewCorners { .. } => "face with too few corners",
            Defect::RepeatedCorner { .. } => "face with a repeated corner",
            Defect::InconsistentOrientation { .. } => "edge between faces that disagree",
            Defect::NonManifoldEdge { .. } => "edge with more than two faces",
            Defect::NonManifoldVertex { .. } => "vertex with several fans",
            _ => "other defect",
        };
        *tally.entry(kind).or_default() += 1;
    }
    tally
}
