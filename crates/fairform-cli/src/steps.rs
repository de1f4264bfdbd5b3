//! Repair steps: made in a fixed order, written as options, and found for a mesh that needs them.

use std::fmt;

use fairform::repair::{BadDistance, Soup};
use fairform::{Defect, Error, Faces, Mesh, Topology, Vec3, VertexId};

/// Which steps to make. Shown as the options that ask for them.
#[expect(clippy::struct_excessive_bools, reason = "one switch per step")]
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Steps {
    pub(crate) weld: Option<f64>,
    pub(crate) drop_degenerate: bool,
    pub(crate) drop_duplicates: bool,
    pub(crate) orient: bool,
    pub(crate) split: bool,
    pub(crate) fill_holes: Option<usize>,
    pub(crate) outward: bool,
    pub(crate) triangulate: bool,
    pub(crate) drop_isolated: bool,
}

/// What one step did.
#[derive(Debug)]
pub(crate) struct Done {
    pub(crate) words: String,
    changed: bool,
}

impl Steps {
    /// Makes the steps, in the order in which they stand in the struct.
    pub(crate) fn run(&self, soup: &mut Soup) -> Result<Vec<Done>, BadDistance> {
        let mut done = Vec::new();
        let mut say = |step: &str, report: &dyn fmt::Display, changed| {
            done.push(Done { words: format!("{step}: {report}"), changed });
        };
        if let Some(distance) = self.weld {
            let report = soup.weld(distance)?;
            say("weld", &report, report.changed());
        }
        if self.drop_degenerate {
            let report = soup.drop_degenerate();
            say("drop degenerate", &report, report.changed());
        }
        if self.drop_duplicates {
            let report = soup.drop_duplicates();
            say("drop duplicates", &report, report.changed());
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
            say("fill holes", &report, report.changed());
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
            say("drop isolated", &report, report.changed());
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

/// The fewest steps known to turn faces into a manifold mesh of triangles: made, not guessed.
///
/// Vertices at the same place are joined if that closes gaps. `None` if nothing would be left.
pub(crate) fn remedy(positions: &[Vec3], faces: &Faces) -> Option<Steps> {
    let plain = search(positions, faces, Steps::default());
    let weld = Steps { weld: Some(0.0), ..Steps::default() };
    let welded = (coincident(positions) > 0).then(|| search(positions, faces, weld)).flatten();
    let better = match (plain, welded) {
        (Some(plain), Some(welded)) if welded.boundary_edges < plain.boundary_edges => Some(welded),
        (None, welded) => welded,
        (plain, _) => plain,
    };
    better.map(|remedy| remedy.steps)
}

/// The steps that close gaps between vertices at the same place, if there are such gaps.
pub(crate) fn joining(mesh: &Mesh) -> Option<Steps> {
    if !has_gaps(mesh) {
        return None;
    }
    let topology = mesh.topology();
    let weld = Steps { weld: Some(0.0), ..Steps::default() };
    let welded = search(mesh.positions(), &topology.to_faces(), weld)?;
    (welded.boundary_edges < boundary_edges(topology)).then_some(welded.steps)
}

/// Adds what the defects ask for until none is left.
fn search(positions: &[Vec3], faces: &Faces, mut steps: Steps) -> Option<Remedy> {
    loop {
        let mut soup = Soup::new(positions.to_vec(), faces.clone());
        let done = steps.run(&mut soup).ok()?;
        let before = steps.clone();
        match Mesh::new(soup.positions, &soup.faces) {
            Ok(mesh) => match mesh.topology().uniform_face_size() {
                _ if mesh.topology().face_count() == 0 => return None,
                Some(3) => {
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
pub(crate) fn coincident(positions: &[Vec3]) -> usize {
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
        remedy(positions, faces).map(|steps| steps.to_string())
    }

    #[test]
    fn a_polygon_is_cut() {
        let square = Faces::uniform(4, vec![0, 1, 2, 3]);
        assert_eq!(options(&SQUARE, &square).as_deref(), Some("--triangulate"));
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
