//! Evaluation of the limit surface anywhere: position, derivatives and normal at any parameters of
//! any face.
//!
//! Where the mesh is regular the surface is a spline and is evaluated as such. Elsewhere a face falls
//! into infinitely many regular patches that shrink towards its extraordinary corners; a point is
//! followed to its patch by exact refinement of a few control points, as in \[Stam1998\] but for any
//! rules: boundaries, creases of any sharpness, several extraordinary corners. There is no
//! approximation other than rounding.
//!
//! # Parameters
//!
//! - **Triangles** (Loop): $`u, v \ge 0`$, $`u + v \le 1`$. The corners of the face, in order, are
//!   (0, 0), (1, 0), (0, 1).
//! - **Quadrilaterals** (Catmull–Clark, Doo–Sabin): $`0 \le u, v \le 1`$. The corners are (0, 0),
//!   (1, 0), (1, 1), (0, 1).
//! - **Other polygons** fall into a quadrilateral for each corner: from the corner, (0, 0), to the
//!   middle of the side to the next corner, (1, 0), to the centre of the face, (1, 1), and to the
//!   middle of the side from the previous corner, (0, 1).
//!
//! For Loop and Catmull–Clark the corner of a face goes to the limit point of its vertex, and the
//! parameters are those in which the regular surface is a spline. Doo and Sabin's scheme is dual: the
//! limit point of an inner vertex is where the corners of its faces go too, and centres go to the
//! centroids of faces; but round a boundary vertex the corners of the faces only touch the boundary if
//! there are two of them. The surface goes on beyond the boundary sides of faces, by a strip half as
//! wide as a face, with negative parameters: $`-1 \le v < 0`$ beyond the first side of a corner's
//! quadrilateral if that is on the boundary, $`-1 \le u < 0`$ beyond the last. In quadrilaterals that
//! is the range from $`-1/2`$ to $`3/2`$. The limit point of the boundary vertex is at $`(0, -1)`$.
//!
//! # Smoothness
//!
//! The surface is $`C^2`$ for Loop and Catmull–Clark and $`C^1`$ for Doo–Sabin, except at
//! extraordinary points, where it has a normal but no derivatives by these parameters, and across
//! creases, where the result is that of the side of the face. Doo–Sabin's second derivatives are those
//! of one of the patches where several meet, and the first derivative across its boundary is zero there.

use alloc::vec::Vec;

use crate::error::Error;
use crate::ids::{FaceId, HalfedgeId, NONE, VertexId};
use crate::refine::refine;
use crate::scheme::{Border, Rules, Scheme};
use crate::{Stencils, Topology, Vec3, par};

pub(crate) mod basis;
pub(crate) mod graph;
mod map;
mod neighbourhood;
mod parts;
mod patch;

use graph::Graph;
use map::Map;
pub(crate) use neighbourhood::{Gatherer, Neighbourhood};
pub(crate) use parts::{Parts, face_count};
use parts::{beginning, is_covered};
pub(crate) use patch::Sector;

/// Most faces of a neighbourhood that is looked at beforehand. Larger ones are looked at when they
/// are needed, so that the memory is never quadratic in the valence.
const MOST_FACES: u32 = 256;

/// A place on a surface: parameters within a face, see the [module](self).
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Location {
    /// The face.
    pub face: FaceId,
    /// In a polygon with other than the usual number of corners: the corner whose quadrilateral the
    /// parameters are for. Zero otherwise.
    pub corner: u32,
    /// First parameter.
    pub u: f64,
    /// Second parameter.
    pub v: f64,
}

impl Location {
    /// Parameters of a triangle or quadrilateral.
    #[must_use]
    pub const fn new(face: FaceId, u: f64, v: f64) -> Self {
        Self { face, corner: 0, u, v }
    }

    /// Parameters of the quadrilateral at a corner of a polygon.
    #[must_use]
    pub const fn at_corner(face: FaceId, corner: u32, u: f64, v: f64) -> Self {
        Self { face, corner, u, v }
    }
}

/// The limit surface at a [`Location`].
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Sample {
    /// The point.
    pub position: Vec3,
    /// The derivatives by $`u`$ and by $`v`$; `None` at an extraordinary point.
    pub first: Option<[Vec3; 2]>,
    /// The second derivatives by $`uu`$, $`uv`$, $`vv`$; `None` at an extraordinary point, near which
    /// they may grow without bounds.
    pub second: Option<[Vec3; 3]>,
    /// The unit normal, outwards for counter-clockwise faces; zero where the tangents are parallel.
    /// On a curve with many faces on a side (5 for Catmull–Clark, 7 on a crease for Loop) the surface
    /// has no unique normal at the vertex, and the result is the one along the curve.
    /// At a boundary vertex with two faces Loop's limit surface has none, and the result is that of
    /// [`limit_normals`](crate::limit::limit_normals).
    pub normal: Vec3,
}

/// Evaluates the limit surfaces of all meshes of one connectivity.
///
/// ```
/// use fairform::evaluate::{Evaluator, Location};
/// use fairform::{FaceId, Rules, shapes};
///
/// let mesh = shapes::icosahedron();
/// let evaluator = Evaluator::new(mesh.topology(), &Rules::LOOP)?;
/// let middle = Location::new(FaceId(0), 1.0 / 3.0, 1.0 / 3.0);
/// let sample = evaluator.evaluate(mesh.positions(), middle)?;
/// assert!(sample.normal.dot(sample.position.normalized()) > 0.999_999);
/// # Ok::<(), fairform::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Evaluator<'t> {
    coarse: &'t Topology,
    /// Its boundary half-edges, if they have images.
    boundary: Vec<HalfedgeId>,
    scheme: Scheme,
    /// The mesh after one step: its faces, or vertices for Doo–Sabin, are the parts that the surface
    /// is cut into first.
    finer: Topology,
    next: Rules,
    first: Stencils,
    parts: Parts,
}

/// A place in a part of the surface.
struct Place {
    part: usize,
    at: [f64; 2],
    jacobian: [[f64; 2]; 2],
}

impl<'t> Evaluator<'t> {
    /// Looks at all faces. Takes time and memory in proportion to the mesh.
    ///
    /// # Errors
    /// As [`refine`](crate::refine::refine()).
    pub fn new(topology: &'t Topology, rules: &Rules) -> Result<Self, Error> {
        // The interpolating schemes have no piecewise polynomial limit; beyond here they do not occur.
        if rules.scheme.is_interpolating() {
            let (what, scheme) = ("exact evaluation", rules.scheme.name());
            return Err(Error::NotForScheme { what, scheme });
        }
        let step = refine(topology, rules)?;
        let first = step.stencils();
        let (finer, next) = (step.topology, step.next);
        let scheme = rules.scheme;
        let parts = Parts::new(&finer, &next, MOST_FACES)?;
        let boundary = if scheme == Scheme::DooSabin { boundary(topology) } else { Vec::new() };
        Ok(Self { coarse: topology, boundary, scheme, finer, next, first, parts })
    }

    /// The surface at a place, for control points `points`.
    ///
    /// # Errors
    /// [`Error::BadOption`] if there is no such face or corner, or the parameters are out of their
    /// range; [`Error::NoLimit`] next to a vertex that Doo and Sabin's scheme gives no surface: one
    /// with two faces, or on the boundary with [`Border::Drop`].
    ///
    /// # Panics
    /// If there is not one point per vertex.
    pub fn evaluate(&self, points: &[Vec3], location: Location) -> Result<Sample, Error> {
        assert_eq!(points.len(), self.coarse.vertex_count(), "one point per vertex");
        self.sample(points, location, &mut Vec::new())
    }

    /// [`evaluate`](Self::evaluate) at many places.
    ///
    /// # Errors
    /// As [`evaluate`](Self::evaluate), for the first place that has one.
    ///
    /// # Panics
    /// If there is not one point per vertex.
    pub fn evaluate_many(
        &self,
        points: &[Vec3],
        locations: &[Location],
    ) -> Result<Vec<Sample>, Error> {
        assert_eq!(points.len(), self.coarse.vertex_count(), "one point per vertex");
        let blocks = par::blocks(locations.len(), |range| {
            let mut values = Vec::new();
            let one = |&at: &Location| self.sample(points, at, &mut values);
            locations[range].iter().map(one).collect::<Result<Vec<_>, _>>()
        });
        let mut samples = Vec::with_capacity(locations.len());
        for block in blocks {
            samples.extend(block?);
        }
        Ok(samples)
    }

    fn sample(
        &self,
        points: &[Vec3],
        location: Location,
        values: &mut Vec<Vec3>,
    ) -> Result<Sample, Error> {
        let place = self.place(location)?;
        let mut fill = |vertices: &[VertexId]| {
            values.clear();
            values.extend(vertices.iter().map(|v| -> Vec3 {
                self.first.row(v.index()).map(|(q, w)| w * points[q.index()]).sum()
            }));
        };
        let (at, jacobian) = (place.at, place.jacobian);
        let node = self.parts.node[place.part];
        if node != NONE {
            fill(self.parts.vertices(place.part));
            return Ok(self.parts.graph.sample(self.scheme, node, values, at, jacobian));
        }
        let found = self.look_at(place.part, location)?;
        fill(&found.vertices[..found.value_count]);
        let mut graph = Graph::default();
        let node = graph.node(found, &self.next)?;
        Ok(graph.sample(self.scheme, node, values, at, jacobian))
    }

    fn look_at(&self, part: usize, location: Location) -> Result<Neighbourhood, Error> {
        let h = beginning(&self.finer, self.scheme, part);
        if let Some(h) = h.filter(|&h| is_covered(&self.finer, &self.next, h)) {
            return Ok(Gatherer::new(&self.finer, &self.next).gather(h));
        }
        let vertex = if part < self.coarse.halfedge_count() {
            self.coarse.origin(HalfedgeId(part as u32))
        } else {
            self.coarse.face_vertices(location.face)[0]
        };
        let reason = if self.coarse.is_boundary(vertex) {
            "it is on the boundary, which is dropped"
        } else {
            "it has only two faces"
        };
        Err(Error::NoLimit { vertex, scheme: self.scheme.name(), reason })
    }

    /// Finds the part of a location.
    fn place(&self, location: Location) -> Result<Place, Error> {
        let Location { face, corner, u, v } = location;
        let expected = "that of a face";
        if face.index() >= self.coarse.face_count() {
            let (what, value) = ("the number of the face", f64::from(face.0));
            return Err(Error::BadOption { what, expected, value });
        }
        let size = self.coarse.face_halfedges(face).len();
        let first = self.coarse.face_halfedges(face).next().map_or(0, |h| h.0);
        let is_whole = match self.scheme {
            Scheme::Loop | Scheme::Butterfly => true,
            _ => size == 4,
        };
        if corner as usize >= if is_whole { 1 } else { size } {
            let (what, value) = ("the number of the corner", f64::from(corner));
            let expected = if is_whole { "zero for such a face" } else { "that of a corner" };
            return Err(Error::BadOption { what, expected, value });
        }
        if self.scheme == Scheme::Loop {
            check("u", u, 0.0, 1.0)?;
            check("v", v, 0.0, 1.0)?;
            // One more rounding than in u = 1 - v.
            check("u + v", u + v, 0.0, 1.0 + 2.0 * f64::EPSILON)?;
            let i = map::part_of_triangle([u, v]);
            return Ok(Place::new(4 * face.index() + i, [u, v], &[map::TRIANGLE[i]]));
        }
        let (low, high) = match (self.scheme, is_whole) {
            (Scheme::DooSabin, true) => (-0.5, 1.5),
            (Scheme::DooSabin, false) => (-1.0, 1.0),
            _ => (0.0, 1.0),
        };
        check("u", u, low, high)?;
        check("v", v, low, high)?;
        let (i, to_corner) = if is_whole {
            let i = map::part_of_square([u, v]);
            (i, map::QUADRILATERAL[i])
        } else {
            (corner as usize, Map::IDENTITY)
        };
        let part = first as usize + i;
        if self.scheme == Scheme::CatmullClark {
            return Ok(Place::new(part, [u, v], &[to_corner]));
        }
        let h = HalfedgeId(part as u32);
        let bspline = self.next.border == Border::Bspline;
        let is_free = |h| bspline && self.coarse.twin(h).is_none();
        let images = |h| boundary_images(self.coarse, &self.boundary, h);
        let [s, t] = to_corner.apply([u, v]);
        // Back on the face where there is nothing beyond its side.
        if t < 0.0 {
            let nothing = s < 0.0 || !is_free(h);
            check("the parameter across the boundary", t, if nothing { 0.0 } else { -1.0 }, 1.0)?;
            let part = images(h)[0] as usize;
            return Ok(Place::new(part, [u, v], &[to_corner, map::FIRST_STRIP]));
        }
        if s < 0.0 {
            let back = self.coarse.prev(h);
            let nothing = !is_free(back);
            check("the parameter across the boundary", s, if nothing { 0.0 } else { -1.0 }, 1.0)?;
            let part = images(back)[1] as usize;
            return Ok(Place::new(part, [u, v], &[to_corner, map::LAST_STRIP]));
        }
        Ok(Place::new(part, [u, v], &[to_corner]))
    }
}

impl Place {
    fn new(part: usize, at: [f64; 2], maps: &[Map]) -> Self {
        let mut place = Self { part, at, jacobian: Map::IDENTITY.jacobian() };
        for map in maps {
            place.at = map.apply(place.at);
            place.jacobian = map.jacobian_after(place.jacobian);
        }
        place
    }
}

fn check(what: &'static str, value: f64, low: f64, high: f64) -> Result<(), Error> {
    if value >= low && value <= high {
        return Ok(());
    }
    Err(Error::BadOption { what, expected: "in the range of the face", value })
}

/// The half-edges on the boundary, in order.
fn boundary(topology: &Topology) -> Vec<HalfedgeId> {
    topology.halfedges().filter(|&h| topology.twin(h).is_none()).collect()
}

/// The images of the two ends of a boundary half-edge in Doo and Sabin's step.
fn boundary_images(topology: &Topology, boundary: &[HalfedgeId], h: HalfedgeId) -> [u32; 2] {
    let before = boundary.partition_point(|&g| g < h);
    let first = topology.halfedge_count() as u32 + 2 * before as u32;
    [first, first + 1]
}
