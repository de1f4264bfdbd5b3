//! Repair steps: made in a fixed order, named or written as options, and found for a mesh that needs
//! them. What each does is said in [`fairform::repair`].
//!
//! ```
//! use fairform_io::{Format, parse, repair};
//!
//! // Two triangles, one turned over.
//! let data = parse(b"OFF 4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 3 2\n", Format::Off)?;
//! let steps = repair::remedy(&data.positions, &data.faces, true).unwrap();
//! assert_eq!(steps.to_string(), "--orient");
//! let (repaired, done) = repair::run(data, &steps)?;
//! assert_eq!(repaired.faces.get(fairform::FaceId(1)), [0, 2, 3]);
//! assert_eq!((done[0].step, done.len()), ("orient", 1));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::fmt;

use fairform::repair::{BadDistance, Soup};
use fairform::{Defect, Error, Faces, Mesh, NONE, Topology, Vec3, VertexId};

use crate::data::{Labels, MeshData};

/// Which steps to make. Shown as the options of `fairform repair` that ask for them.
#[expect(clippy::struct_excessive_bools, reason = "one switch per step")]
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Steps {
    /// Join vertices that are no farther apart than this, in units of the mesh.
    pub weld: Option<f64>,
    /// Remove faces that are no polygons.
    pub drop_degenerate: bool,
    /// Remove faces that are there already.
    pub drop_duplicates: bool,
    /// Turn faces so that neighbours agree.
    pub orient: bool,
    /// Cut the mesh apart where it is no manifold.
    pub split: bool,
    /// Fill holes of so many edges at most.
    pub fill_holes: Option<usize>,
    /// Turn closed parts so that their faces look outward.
    pub outward: bool,
    /// Cut polygons into triangles.
    pub triangulate: bool,
    /// Remove vertices without faces.
    pub drop_isolated: bool,
}

/// What one step did.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Done {
    /// Its name, as [`Steps::ask`] knows it.
    pub step: &'static str,
    /// What it did, in words.
    pub words: String,
    /// Whether that was anything.
    pub changed: bool,
}

impl fmt::Display for Done {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.step.replace('-', " "), self.words)
    }
}

/// There is no step of that name, or no such distance or number.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "no such repair step: {0:?}; there are weld, weld=DISTANCE, drop-degenerate, drop-duplicates, \
     orient, split, fill-holes=EDGES, outward, triangulate, drop-isolated"
)]
pub struct UnknownStep(pub String);

/// The data after some steps, with attributes and labels that follow them; and what each step did.
/// Crease tags stay only where vertices and faces keep their numbers; a note says if some do not.
///
/// # Errors
/// If the distance for welding is negative or not finite.
pub fn run(data: MeshData, steps: &Steps) -> Result<(MeshData, Vec<Done>), BadDistance> {
    let mut soup = Soup::new(data.positions.clone(), data.faces.clone());
    let done = steps.run(&mut soup)?;
    let keeps_numbers = soup.vertex_source.iter().copied().eq(0..data.positions.len() as u32);
    let mut creases = data.creases.clone().filter(|_| keeps_numbers);
    if let Some(creases) = &mut creases {
        let keeps_faces = soup.face_source.iter().copied().eq(0..data.faces.len() as u32);
        creases.holes.retain(|_| keeps_faces);
    }
    let notes = match creases == data.creases {
        true => Vec::new(),
        false => vec!["crease tags left out where vertices or faces have new numbers".into()],
    };
    Ok((MeshData { creases, notes, ..follow(data, soup) }, done))
}

/// Lets attributes and labels follow the vertices, corners and faces.
fn follow(data: MeshData, soup: Soup) -> MeshData {
    fn gather<T: Clone>(values: Option<Vec<T>>, source: &[u32], new: &T) -> Option<Vec<T>> {
        let values = values?;
        let one = |&s: &u32| if s == NONE { new.clone() } else { values[s as usize].clone() };
        Some(source.iter().map(one).collect())
    }
    let labels = |labels: Option<Labels>| {
        let mut labels = labels?;
        if soup.face_source.contains(&NONE) {
            labels.names.push("filled".into());
        }
        let filled = labels.names.len() as u32 - 1;
        let of_face = gather(Some(labels.of_face), &soup.face_source, &filled)?;
        Some(Labels { names: labels.names, of_face })
    };
    MeshData {
        normals: gather(data.normals, &soup.vertex_source, &Vec3::ZERO),
        colours: gather(data.colours, &soup.vertex_source, &[1.0; 4]),
        uvs: gather(data.uvs, &soup.vertex_source, &[0.0; 2]),
        corner_normals: gather(data.corner_normals, &soup.corner_source, &Vec3::ZERO),
        corner_uvs: gather(data.corner_uvs, &soup.corner_source, &[0.0; 2]),
        groups: labels(data.groups),
        materials: labels(data.materials),
        material_library: data.material_library,
        creases: None,
        notes: Vec::new(),
        positions: soup.positions,
        faces: soup.faces,
    }
}

impl Steps {
    /// Asks for the step of a name, as those of the options of `fairform repair`: `orient`, `weld`
    /// (of vertices at the same place), `weld=0.01`, `fill-holes=12`.
    ///
    /// # Errors
    /// [`UnknownStep`].
    pub fn ask(&mut self, name: &str) -> Result<(), UnknownStep> {
        let unknown = || UnknownStep(name.into());
        match name.split_once('=').unwrap_or((name, "")) {
            ("weld", "") => self.weld = Some(0.0),
            ("weld", distance) => {
                let distance = distance.parse::<f64>().ok();
                let distance = distance.filter(|d| d.is_finite() && *d >= 0.0);
                self.weld = Some(distance.ok_or_else(unknown)?);
            }
            ("fill-holes", edges) => {
                self.fill_holes = Some(edges.parse().map_err(|_| unknown())?);
            }
            ("drop-degenerate", "") => self.drop_degenerate = true,
            ("drop-duplicates", "") => self.drop_duplicates = true,
            ("orient", "") => self.orient = true,
            ("split", "") => self.split = true,
            ("outward", "") => self.outward = true,
            ("triangulate", "") => self.triangulate = true,
            ("drop-isolated", "") => self.drop_isolated = true,
            _ => return Err(unknown()),
        }
        Ok(())
    }

    /// The steps of some names; they are made in the order of the struct, whatever the order here.
    ///
    /// # Errors
    /// [`UnknownStep`].
    pub fn named<S: AsRef<str>>(names: &[S]) -> Result<Self, UnknownStep> {
        let mut steps = Self::default();
        names.iter().try_for_each(|name| steps.ask(name.as_ref()))?;
        Ok(steps)
    }

    /// Makes the steps, in the order in which they stand in the struct.
    ///
    /// # Errors
    /// If the distance for welding is negative or not finite.
    pub fn run(&self, soup: &mut Soup) -> Result<Vec<Done>, BadDistance> {
        let mut done = Vec::new();
        let mut say = |step: &'static str, report: &dyn fmt::Display, changed| {
            done.push(Done { step, words: report.to_string(), changed });
        };
        if let Some(distance) = self.weld {
            let report = soup.weld(distance)?;
            say("weld", &report, report.changed());
        }
        if self.drop_degenerate {
            let report = soup.drop_degenerate();
            say("drop-degenerate", &report, report.changed());
        }
        if self.drop_duplicates {
            let report = soup.drop_duplicates();
            say("drop-duplicates", &report, report.changed());
        }
        if self.orient {
            let report = soup.orient();
            say("orient", &report, report.changed());
        }
        if self.split {
            let report = soup.split_non_manifold();
            say("split", &report, report.changed());
        }
        if let Some(edges) = self.fill_holes {
            let report = soup.fill_holes(edges);
            say("fill-holes", &report, report.changed());
        }
        if self.outward {
            let report = soup.orient_outward();
            say("outward", &report, report.changed());
        }
        if self.triangulate {
            let report = soup.triangulate();
            say("triangulate", &report, report.changed());
        }
        if self.drop_isolated {
            let report = soup.drop_isolated();
            say("drop-isolated", &report, report.changed());
        }
        Ok(done)
    }

    /// Adds what mends a defect.
    fn add(&mut self, defect: &Defect) {
        match defect {
            Defect::NotFinite { .. } => {
                self.drop_degenerate = true;
                self.drop_isolated = true;
            }
            Defect::NoSuchVertex { .. }
            | Defect::TooFewCorners { .. }
            | Defect::RepeatedCorner { .. } => self.drop_degenerate = true,
            Defect::InconsistentOrientation { .. } => {
                self.drop_duplicates = true;
                self.orient = true;
            }
            Defect::NonManifoldEdge { .. } => {
                self.drop_duplicates = true;
                self.orient = true;
                self.split = true;
            }
            _ => self.split = true,
        }
    }

    /// Leaves out the steps that did nothing.
    fn without_idle(mut self, done: &[Done]) -> Self {
        let mut done = done.iter().map(|step| step.changed);
        let mut changed = |asked: bool| asked && done.next().is_some_and(|changed| changed);
        if !changed(self.weld.is_some()) {
            self.weld = None;
        }
        self.drop_degenerate = changed(self.drop_degenerate);
        self.drop_duplicates = changed(self.drop_duplicates);
        self.orient = changed(self.orient);
        self.split = changed(self.split);
        if !changed(self.fill_holes.is_some()) {
            self.fill_holes = None;
        }
        self.outward = changed(self.outward);
        self.triangulate = changed(self.triangulate);
        self.drop_isolated = changed(self.drop_isolated);
        self
    }
}

impl fmt::Display for Steps {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let option = |asked: bool, name: &str| asked.then(|| name.to_string());
        let options = [
            self.weld.map(|distance| format!("--weld {distance}")),
            option(self.drop_degenerate, "--drop-degenerate"),
            option(self.drop_duplicates, "--drop-duplicates"),
            option(self.orient, "--orient"),
            option(self.split, "--split"),
            self.fill_holes.map(|edges| format!("--fill-holes {edges}")),
            option(self.outward, "--outward"),
            option(self.triangulate, "--triangulate"),
            option(self.drop_isolated, "--drop-isolated"),
        ];
        f.write_str(&options.into_iter().flatten().collect::<Vec<_>>().join(" "))
    }
}

/// Steps that make a mesh fit for fitting, and what they lead to.
#[derive(Debug)]
struct Remedy {
    steps: Steps,
    boundary_edges: usize,
}

/// The fewest steps known to turn faces into a manifold mesh, if asked for one of triangles: made, not
/// guessed.
///
/// Vertices at the same place are joined if that closes gaps. `None` if nothing would be left.
#[must_use]
pub fn remedy(positions: &[Vec3], faces: &Faces, triangles: bool) -> Option<Steps> {
    let plain = search(positions, faces, Steps::default(), triangles);
    let weld = Steps { weld: Some(0.0), ..Steps::default() };
    let welded =
        (coincident(positions) > 0).then(|| search(positions, faces, weld, triangles)).flatten();
    let better = match (plain, welded) {
        (Some(plain), Some(welded)) if welded.boundary_edges < plain.boundary_edges => Some(welded),
        (None, welded) => welded,
        (plain, _) => plain,
    };
    better.map(|remedy| remedy.steps)
}

/// The steps that close gaps between vertices at the same place, if there are such gaps, and cut
/// polygons into triangles.
#[must_use]
pub fn joining(mesh: &Mesh) -> Option<Steps> {
    if !has_gaps(mesh) {
        return None;
    }
    let topology = mesh.topology();
    let weld = Steps { weld: Some(0.0), ..Steps::default() };
    let welded = search(mesh.positions(), &topology.to_faces(), weld, true)?;
    (welded.boundary_edges < boundary_edges(topology)).then_some(welded.steps)
}

/// Adds what the defects ask for until none is left.
fn search(positions: &[Vec3], faces: &Faces, mut steps: Steps, triangles: bool) -> Option<Remedy> {
    loop {
        let mut soup = Soup::new(positions.to_vec(), faces.clone());
        let done = steps.run(&mut soup).ok()?;
        let before = steps.clone();
        match Mesh::new(soup.positions, &soup.faces) {
            Ok(mesh) => match mesh.topology().uniform_face_size() {
                _ if mesh.topology().face_count() == 0 => return None,
                size if size == Some(3) || !triangles => {
                    let boundary_edges = boundary_edges(mesh.topology());
                    return Some(Remedy { steps: steps.without_idle(&done), boundary_edges });
                }
                _ => steps.triangulate = true,
            },
            Err(Error::NotManifold(defects)) => defects.0.iter().for_each(|d| steps.add(d)),
            Err(_) => return None,
        }
        if steps == before {
            // What turning faces does not mend, such as a Möbius strip, is cut.
            if steps.split {
                return None;
            }
            steps.split = true;
        }
    }
}

fn boundary_edges(topology: &Topology) -> usize {
    2 * topology.edge_count() - topology.halfedge_count()
}

/// Whether some edge of the boundary lies exactly on another.
fn has_gaps(mesh: &Mesh) -> bool {
    let topology = mesh.topology();
    let place = |v: VertexId| place(&mesh.positions()[v.index()]);
    let open = topology.halfedges().filter(|&h| topology.twin(h).is_none());
    let mut edges: Vec<_> = open
        .map(|h| {
            let (a, b) = (place(topology.origin(h)), place(topology.target(h)));
            if a < b { [a, b] } else { [b, a] }
        })
        .collect();
    edges.sort_unstable();
    edges.windows(2).any(|w| w[0] == w[1])
}

/// Number of vertices at exactly the position of an earlier one.
#[must_use]
pub fn coincident(positions: &[Vec3]) -> usize {
    let mut places: Vec<_> = positions.iter().filter(|p| p.is_finite()).map(place).collect();
    places.sort_unstable();
    places.windows(2).filter(|w| w[0] == w[1]).count()
}

/// A position that can be compared and sorted. Zero is zero, whatever its sign.
fn place(p: &Vec3) -> [u64; 3] {
    [p.x + 0.0, p.y + 0.0, p.z + 0.0].map(f64::to_bits)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: [Vec3; 4] = [
        Vec3::new(0.0, 0.0, 0.0),
        Vec3::new(1.0, 0.0, 0.0),
        Vec3::new(1.0, 1.0, 0.0),
        Vec3::new(0.0, 1.0, 0.0),
    ];

    fn options(positions: &[Vec3], faces: &Faces) -> Option<String> {
        remedy(positions, faces, true).map(|steps| steps.to_string())
    }

    #[test]
    fn a_polygon_is_cut() {
        let square = Faces::uniform(4, vec![0, 1, 2, 3]);
        assert_eq!(options(&SQUARE, &square).as_deref(), Some("--triangulate"));
    }

    #[test]
    fn a_polygon_may_stay_whole() {
        let square = Faces::uniform(4, vec![0, 1, 2, 3]);
        assert_eq!(remedy(&SQUARE, &square, false), Some(Steps::default()));
    }

    /// What is advised is what the names of the steps ask for.
    #[test]
    fn steps_have_names() {
        let names = ["split", "weld=0.5", "fill-holes=12", "orient"];
        let steps = Steps::named(&names).unwrap();
        assert_eq!(steps.to_string(), "--weld 0.5 --orient --split --fill-holes 12");
        let turned = Faces::uniform(3, vec![0, 1, 2, 0, 3, 2, 0, 1, 1]);
        let mut soup = Soup::new(SQUARE.to_vec(), turned);
        let all = ["drop-degenerate", "drop-duplicates", "outward", "triangulate", "drop-isolated"];
        let done = Steps::named(&all).unwrap().run(&mut soup).unwrap();
        assert_eq!(done.iter().map(|done| done.step).collect::<Vec<_>>(), all);
        for name in ["", "Orient", "weld=-1", "weld=x", "fill-holes", "orient=1"] {
            assert_eq!(Steps::default().ask(name), Err(UnknownStep(name.into())));
        }
    }

    #[test]
    fn only_steps_that_do_something_are_named() {
        let turned = Faces::uniform(3, vec![0, 1, 2, 0, 3, 2, 0, 1, 1]);
        let expected = Some("--drop-degenerate --orient");
        assert_eq!(options(&SQUARE, &turned).as_deref(), expected);
    }

    #[test]
    fn gaps_are_joined_and_wedges_that_touch_are_not() {
        let twice = [SQUARE, SQUARE].concat();
        let apart = Faces::uniform(3, vec![0, 1, 2, 4, 6, 7]);
        assert_eq!(options(&twice, &apart).as_deref(), Some("--weld 0"));
        let touching = Faces::uniform(3, vec![0, 1, 2, 7, 4, 5]);
        let mesh = Mesh::new(
            twice.iter().enumerate().map(|(i, &p)| if i > 4 { p - SQUARE[2] } else { p }).collect(),
            &touching,
        );
        assert_eq!(joining(&mesh.unwrap()), None);
    }

    #[test]
    fn nothing_is_advised_where_nothing_would_be_left() {
        assert_eq!(options(&SQUARE, &Faces::uniform(2, vec![0, 1])), None);
    }
}
