//! Push-back: exact interpolation one level down, whatever the control points.
//!
//! After one refinement step, what the limit point of an old vertex depends on besides the vertex
//! itself is new points only, no other old vertex. So each old vertex can be moved, by itself and
//! explicitly, to where its limit point is the one wanted, whatever the new points are:
//!
//! ```math
//! V^1 = \frac{P - \sum_j b_j N_j}{b}
//! ```
//!
//! with $`b, b_j`$ the limit weights of the vertex and of its new neighbours. For Catmull–Clark that
//! is $`V^1 = [n(n+5) P - 4 \sum E_i - \sum F_i] / n^2`$, on curves $`(6P - e_1 - e_2)/4`$. In Doo
//! and Sabin's scheme a limit point is the mean of the images of its vertex, and each image has one
//! vertex, so all of them are moved alike. \[Deng2010\]

use alloc::vec::Vec;

use crate::crease::Kind;
use crate::error::Error;
use crate::ids::{HalfedgeId, VertexId};
use crate::limit::{self, LimitRows};
use crate::refine::{Refined, boundary_numbers, refine};
use crate::rows::{self, Rows};
use crate::scheme::{Rules, Scheme};
use crate::{Stencils, Topology, Vec3, par};

/// The first vertex of each connected component on which the limit operator is singular, so that no
/// control points interpolate every target there: Catmull–Clark on closed components without creases
/// in which every vertex has three faces and the edges connect two colours of vertices, such as a cube
/// or any prism with an even number of sides.
///
/// Found by colouring, not by iterating. Rules that do not fit the topology have none.
#[must_use]
pub fn singular_components(topology: &Topology, rules: &Rules) -> Vec<VertexId> {
    let is_singular = |&(_, fans): &(_, [u64; 2])| fans == [0, 0];
    plain_components(topology, rules).into_iter().filter(is_singular).map(|c| c.0).collect()
}

/// Whether the limit operator is known to have an eigenvalue that is not positive, so that no
/// iteration converges for every target, though control points may exist: with the vertices of a closed
/// part coloured ±1 as for [`singular_components`], its quadratic form is $`\sum n(n-3)`$, and each
/// vertex with two faces takes 2 from that.
#[must_use]
pub fn is_not_definite(topology: &Topology, rules: &Rules) -> bool {
    plain_components(topology, rules).iter().any(|&(_, [minus, plus])| minus >= plus)
}

/// The first vertex of each connected component of Catmull–Clark without boundary and creases whose
/// vertices can be coloured so that edges connect two colours; and the sum of $`n(n-3)`$ over its
/// vertices with $`n`$ faces, its negative and its positive part.
fn plain_components(topology: &Topology, rules: &Rules) -> Vec<(VertexId, [u64; 2])> {
    if rules.scheme != Scheme::CatmullClark || rules.check(topology).is_err() {
        return Vec::new();
    }
    let sharp = rules.sharpness(topology);
    let is_plain = |v: VertexId| {
        !topology.is_isolated(v)
            && !topology.is_boundary(v)
            && sharp.vertex(v) == 0.0
            && sharp.edges(v).all(|e| sharp.edge(e.0) == 0.0)
    };
    let mut colour = alloc::vec![Colour::None; topology.vertex_count()];
    let (mut found, mut queue) = (Vec::new(), Vec::new());
    for seed in topology.vertices() {
        if colour[seed.index()] != Colour::None || !is_plain(seed) {
            continue;
        }
        let mut is_plain_part = true;
        let mut fans = [0; 2];
        colour[seed.index()] = Colour::Black;
        queue.push(seed);
        while let Some(v) = queue.pop() {
            let n = u64::from(topology.fan_size(v));
            fans[usize::from(n > 2)] += if n > 2 { n * (n - 3) } else { n * (3 - n) };
            let own = colour[v.index()];
            let other = if own == Colour::Black { Colour::White } else { Colour::Black };
            for q in topology.ring(v) {
                is_plain_part &= colour[q.index()] != own;
                if colour[q.index()] == Colour::None {
                    if is_plain(q) {
                        colour[q.index()] = other;
                        queue.push(q);
                    } else {
                        is_plain_part = false;
                    }
                }
            }
        }
        if is_plain_part {
            found.push((seed, fans));
        }
    }
    found
}

/// A colour of [`plain_components`].
#[derive(Clone, Copy, PartialEq)]
enum Colour {
    None,
    Black,
    White,
}

/// A topology refined once, ready to push the limit points of its vertices to where they should be.
#[derive(Clone, Debug)]
pub struct PushBack<'t> {
    coarse: &'t Topology,
    rules: &'t Rules,
    step: Refined<'t>,
    images: Images,
}

/// Doo–Sabin: which images a vertex has.
#[derive(Clone, Debug, Default)]
struct Images {
    /// The number of a half-edge among those on the boundary.
    boundary: Vec<u32>,
    /// The vertex of every image.
    vertex: Vec<VertexId>,
}

impl Images {
    fn new(topology: &Topology) -> Self {
        let mut vertex: Vec<_> = topology.halfedges().map(|h| topology.origin(h)).collect();
        for h in topology.halfedges().filter(|&h| topology.twin(h).is_none()) {
            vertex.extend([topology.origin(h), topology.target(h)]);
        }
        Self { boundary: boundary_numbers(topology).0, vertex }
    }
}

impl<'t> PushBack<'t> {
    /// Refines a topology once.
    ///
    /// # Errors
    /// As [`refine`] and [`limit::limit_stencils`].
    pub fn new(topology: &'t Topology, rules: &'t Rules) -> Result<Self, Error> {
        limit::check(topology, rules)?;
        let images = match rules.scheme {
            Scheme::DooSabin => Images::new(topology),
            _ => Images::default(),
        };
        Ok(Self { coarse: topology, rules, step: refine(topology, rules)?, images })
    }

    /// The refinement step.
    #[must_use]
    pub fn step(&self) -> &Refined<'t> {
        &self.step
    }

    /// The refinement step, by value.
    #[must_use]
    pub fn into_step(self) -> Refined<'t> {
        self.step
    }

    /// The rows that take finer values to the limit points of the coarse vertices, one row per coarse
    /// vertex. For schemes that split faces these are the limit rows of the first vertices of the
    /// finer mesh. For Doo–Sabin they are means of images: an inner vertex has the centroid of the
    /// face it became. There the rows of isolated vertices, which disappear, are empty.
    #[must_use]
    pub fn limit_stencils(&self) -> Stencils {
        rows::stencils(&self.rows(), self.step.topology.vertex_count())
    }

    /// The limit points of the coarse vertices for finer values, see
    /// [`limit_stencils`](Self::limit_stencils).
    ///
    /// # Panics
    /// If there is not one value per finer vertex.
    #[must_use]
    pub fn limit_points(&self, finer: &[Vec3]) -> Vec<Vec3> {
        self.check_finer(finer);
        rows::apply(&self.rows(), finer)
    }

    /// Moves finer values so that the limit points of the coarse vertices are `target`, up to
    /// rounding. Returns the largest distance that a limit point had to be moved.
    ///
    /// # Panics
    /// If there is not one target per coarse vertex and one value per finer vertex.
    pub fn correct(&self, target: &[Vec3], finer: &mut [Vec3]) -> f64 {
        assert_eq!(target.len(), self.coarse.vertex_count(), "one target per vertex");
        self.check_finer(finer);
        let rows = self.rows();
        let moves: Vec<Vec3> = if self.rules.scheme == Scheme::DooSabin {
            let limit = rows::apply(&rows, finer);
            let moves = par::collect(target.len(), |v| {
                let is_isolated = self.coarse.is_isolated(VertexId(v as u32));
                if is_isolated { Vec3::ZERO } else { target[v] - limit[v] }
            });
            par::for_blocks(finer, |start, block| {
                for (i, x) in block.iter_mut().enumerate() {
                    *x += moves[self.images.vertex[start + i].index()];
                }
            });
            moves
        } else {
            let apart: Vec<(f64, Vec3)> =
                par::collect(target.len(), |v| rows.own_and_rest(v, finer));
            let moves = par::collect(target.len(), |v| {
                let (own, rest) = apart[v];
                target[v] - (own * finer[v] + rest)
            });
            par::fill(&mut finer[..target.len()], |v| {
                let (own, rest) = apart[v];
                (target[v] - rest) / own
            });
            moves
        };
        let largest =
            par::blocks(moves.len(), |range| range.map(|v| moves[v].length()).fold(0.0, larger));
        largest.into_iter().fold(0.0, larger)
    }

    /// Doo–Sabin: takes from a change of the finer values what would move limit points, the mean of the
    /// images of each inner vertex. Symmetric, as a projection that is its own transpose.
    pub(crate) fn centre(&self, change: &mut [Vec3]) {
        if self.rules.scheme != Scheme::DooSabin {
            return;
        }
        let means = rows::apply(&self.rows(), change);
        par::for_blocks(change, |start, block| {
            for (i, x) in block.iter_mut().enumerate() {
                let v = self.images.vertex[start + i];
                if !self.coarse.is_boundary(v) {
                    *x += -means[v.index()];
                }
            }
        });
    }

    fn check_finer(&self, finer: &[Vec3]) {
        assert_eq!(finer.len(), self.step.topology.vertex_count(), "one value per finer vertex");
    }

    fn rows(&self) -> CoarseLimitRows<'_> {
        let limit = match self.rules.scheme {
            Scheme::DooSabin => None,
            _ => Some(LimitRows::new(&self.step.topology, &self.step.next)),
        };
        CoarseLimitRows { coarse: self.coarse, images: &self.images, limit }
    }

    /// The finer values that are left to choose once every limit point is held, see [`Freedom`].
    pub(crate) fn freedom(&self) -> Freedom {
        let finer = &self.step.topology;
        let count = finer.vertex_count();
        let mut is_fixed = alloc::vec![false; count];
        let coarse_count = self.coarse.vertex_count();
        if self.rules.scheme == Scheme::DooSabin {
            is_fixed[self.coarse.halfedge_count()..].fill(true);
        } else {
            let sharp = self.rules.sharpness(self.coarse);
            is_fixed[..coarse_count].fill(true);
            for e in self.coarse.edges().filter(|&e| sharp.edge(e) > 0.0) {
                is_fixed[coarse_count + e.index()] = true;
            }
        }
        let mut number = alloc::vec![None; count];
        let mut free = Vec::new();
        for v in finer.vertices().filter(|v| !is_fixed[v.index()]) {
            number[v.index()] = Some(free.len() as u32);
            free.push(v);
        }
        let rows = FreedomRows { pushback: self, limit: self.rows(), number: &number };
        let stencils = rows::stencils(&rows, free.len());
        let sharp = self.step.next.sharpness(finer);
        let is_smooth = par::collect(count, |i| {
            let v = VertexId(i as u32);
            let is_old = self.rules.scheme != Scheme::DooSabin && i < coarse_count;
            (is_old || !is_fixed[i]) && !finer.is_isolated(v) && sharp.kind(v, 0) == Kind::Smooth
        });
        Freedom { stencils, is_smooth }
    }
}

/// What may still be chosen on the finer mesh once every limit point is held: the values at its new
/// vertices off boundaries and creases. The old vertices follow.
pub(crate) struct Freedom {
    /// How a finer value changes with the free ones.
    pub(crate) stencils: Stencils,
    /// Whether a finer vertex is off boundaries and creases.
    pub(crate) is_smooth: Vec<bool>,
}

struct FreedomRows<'a> {
    pushback: &'a PushBack<'a>,
    limit: CoarseLimitRows<'a>,
    number: &'a [Option<u32>],
}

impl Rows for FreedomRows<'_> {
    fn len(&self) -> usize {
        self.number.len()
    }

    fn visit(&self, row: usize, mut entry: impl FnMut(u32, f64)) {
        if let Some(own) = self.number[row] {
            entry(own, 1.0);
        } else if self.pushback.rules.scheme != Scheme::DooSabin
            && row < self.pushback.coarse.vertex_count()
        {
            let mut own = 0.0;
            self.limit.visit(row, |source, weight| {
                own += if source as usize == row { weight } else { 0.0 };
            });
            self.limit.visit(row, |source, weight| {
                if let Some(i) = self.number[source as usize] {
                    entry(i, -weight / own);
                }
            });
        }
    }
}

fn larger(a: f64, b: f64) -> f64 {
    // `f64::max` would drop a NaN, and with it an overflow.
    if b > a || b.is_nan() { b } else { a }
}

/// From finer values to the limit points of the coarse vertices.
struct CoarseLimitRows<'a> {
    coarse: &'a Topology,
    images: &'a Images,
    /// None for Doo–Sabin.
    limit: Option<LimitRows<'a>>,
}

impl CoarseLimitRows<'_> {
    /// The weight of the vertex itself in its limit point, and what the others add to that.
    fn own_and_rest(&self, v: usize, finer: &[Vec3]) -> (f64, Vec3) {
        let (mut own, mut rest) = (0.0, Vec3::ZERO);
        self.visit(v, |source, weight| {
            if source as usize == v {
                own += weight;
            } else {
                rest += weight * finer[source as usize];
            }
        });
        (own, rest)
    }
}

impl Rows for CoarseLimitRows<'_> {
    fn len(&self) -> usize {
        self.coarse.vertex_count()
    }

    fn visit(&self, row: usize, mut entry: impl FnMut(u32, f64)) {
        if let Some(limit) = &self.limit {
            return limit.visit(row, entry);
        }
        let v = VertexId(row as u32);
        if !self.coarse.is_boundary(v) {
            let share = 1.0 / f64::from(self.coarse.fan_size(v).max(1));
            return self.coarse.fan(v).for_each(|h| entry(h.0, share));
        }
        let in_edge = |h: HalfedgeId, end: u32| {
            let first = self.coarse.halfedge_count() as u32;
            first + 2 * self.images.boundary[h.index()] + end
        };
        if let (Some(first), Some(last)) = (self.coarse.outgoing(v), self.coarse.fan(v).last()) {
            entry(in_edge(first, 0), 0.5);
            entry(in_edge(self.coarse.prev(last), 1), 0.5);
        }
    }
}
