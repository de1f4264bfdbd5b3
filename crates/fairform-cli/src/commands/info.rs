//! `fairform info`.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::process::ExitCode;

use fairform::{Bounds, Defect, Error, Mesh, Topology, Vec3};
use fairform_io::MeshData;
use serde_json::{Value, json};

use crate::args::Info;
use crate::console::{Console, count};
use crate::failure::{Failure, in_file};
use crate::input;

pub(crate) fn run(args: &Info, console: &Console) -> Result<ExitCode, Failure> {
    let name = input::name(&args.input.input);
    let data = input::read(&args.input, console)?;
    let facts = Facts::new(data, &name);
    if console.json() {
        console.result(&facts.json(&name))?;
    } else {
        console.print(&facts.text(&name))?;
    }
    Ok(ExitCode::SUCCESS)
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
    connectivity: Result<Connectivity, (Vec<Defect>, Failure)>,
}

struct Connectivity {
    edges: usize,
    loops: usize,
    components: usize,
    genus: usize,
    valence: [u32; 2],
    triangles: bool,
}

impl Facts {
    fn new(data: MeshData, name: &str) -> Self {
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
            ("colours", data.colours.is_some()),
            ("texture coordinates", data.uvs.is_some()),
            ("texture coordinates with seams", data.corner_uvs.is_some()),
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
            connectivity: match Mesh::new(data.positions, &data.faces) {
                Ok(mesh) => Ok(Connectivity::new(mesh.topology())),
                Err(error) => {
                    let failure = in_file(name, &error);
                    match error {
                        Error::NotManifold(defects) => Err((defects.0, failure)),
                        _ => Err((vec![], failure)),
                    }
                }
            },
        }
    }

    fn faces(&self) -> usize {
        self.kinds.values().sum()
    }

    fn kinds(&self) -> String {
        match self.kinds.iter().collect::<Vec<_>>().as_slice() {
            [] => "none".into(),
            [(3, _)] => "triangles".into(),
            [(4, _)] => "quadrilaterals".into(),
            several => {
                let one =
                    |(corners, n): &(&usize, &usize)| format!("{} {corners}-gons", count(**n));
                several.iter().map(one).collect::<Vec<_>>().join(", ")
            }
        }
    }

    fn json(&self, name: &str) -> Value {
        let sound = self.connectivity.as_ref().ok();
        let defects = self.connectivity.as_ref().err().map_or(&[][..], |e| &e.0);
        json!({
            "file": name,
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
            "error": self.connectivity.as_ref().err().map(|e| &e.1.message),
            "help": self.connectivity.as_ref().err().map(|e| &e.1.help),
            "defects": tally(defects).into_iter().map(|(k, n)| (k.to_string(), json!(n)))
                .collect::<serde_json::Map<_, _>>(),
            "first_defects": defects.iter().take(20).map(ToString::to_string).collect::<Vec<_>>(),
        })
    }

    fn text(&self, name: &str) -> String {
        let mut text = format!("{name}\n");
        let mut row = |what: &str, value: String| {
            let _ = writeln!(text, "  {what:<12} {value}");
        };
        row("vertices", count(self.vertices));
        row("faces", format!("{}: {}", count(self.faces()), self.kinds()));
        let (min, max) = (self.bounds.min, self.bounds.max);
        row(
            "box",
            format!("x {} to {}, y {} to {}, z {} to {}", min.x, max.x, min.y, max.y, min.z, max.z),
        );
        match &self.connectivity {
            Ok(c) => {
                row("edges", count(c.edges));
                row("parts", format!("{}, total genus {}", count(c.components), c.genus));
                let closed = "none, the mesh is closed".into();
                row("boundary", if c.loops == 0 { closed } else { format!("{} loops", c.loops) });
                row("valence", format!("{} to {}", c.valence[0], c.valence[1]));
                let fit = "ready for `fairform fit`";
                row("manifold", if c.triangles { format!("yes; {fit}") } else { "yes".into() });
            }
            Err((defects, failure)) => {
                row("manifold", "no".into());
                for (kind, n) in tally(defects) {
                    row("", format!("{} × {kind}", count(n)));
                }
                for defect in defects.iter().take(5) {
                    row("", format!("- {defect}"));
                }
                if defects.len() > 5 {
                    row("", "- …".into());
                }
                if let Some(help) = &failure.help {
                    row("help", help.clone());
                }
            }
        }
        if self.coincident > 0 {
            let weld = "vertices at the place of another; `repair --weld 0` joins them";
            row("coincident", format!("{} {weld}", count(self.coincident)));
        }
        if self.unused > 0 {
            row("isolated", format!("{} vertices without a face", count(self.unused)));
        }
        if !self.attributes.is_empty() {
            row("attributes", self.attributes.join(", "));
        }
        for (what, names) in [("groups", &self.groups), ("materials", &self.materials)] {
            if !names.is_empty() {
                let shown: Vec<_> = names.iter().take(12).map(|n| format!("{n:?}")).collect();
                let more = if names.len() > 12 { ", …" } else { "" };
                row(what, format!("{}: {}{more}", names.len(), shown.join(", ")));
            }
        }
        text
    }
}

impl Connectivity {
    fn new(topology: &Topology) -> Self {
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

/// Number of vertices at exactly the position of an earlier one.
pub(crate) fn coincident(positions: &[Vec3]) -> usize {
    // Zero is zero, whatever its sign; NaN is never equal, but sorts somewhere.
    let key = |p: &Vec3| [p.x + 0.0, p.y + 0.0, p.z + 0.0].map(f64::to_bits);
    let mut keys: Vec<_> = positions.iter().filter(|p| p.is_finite()).map(key).collect();
    keys.sort_unstable();
    keys.windows(2).filter(|w| w[0] == w[1]).count()
}
