//! [`Forms`]: the energies of the limit surface over each kind of part, as quadratic forms.

use alloc::vec::Vec;

use libm::{cos, fabs, sin, sqrt};

use super::Energy;
use super::quadrature;
use crate::crease::{Kind, Sharpness};
use crate::evaluate::Sector;
use crate::evaluate::basis::{self, Jet};
use crate::evaluate::graph::{Corner, Graph, Node, Part, Split};
use crate::ids::{FaceId, HalfedgeId, VertexId};
use crate::scheme::Scheme;
use crate::{Stencils, Topology};

/// Steps towards a vertex without a characteristic map that count.
const MOST_STEPS: u32 = 4;

/// Steps after which a layout of a neighbourhood looks like its own refinement.
const SETTLING: u32 = 4;

/// The forms of the nodes of a graph, found when they are needed.
pub(super) struct Forms<'a> {
    graph: &'a Graph,
    scheme: Scheme,
    /// Of the basis functions of a regular patch.
    basis: Form,
    known: Vec<Option<Form>>,
}

impl<'a> Forms<'a> {
    pub(super) fn new(graph: &'a Graph, scheme: Scheme) -> Self {
        let mut basis = Form::zero(basis_jets(scheme, [0.0; 2]).len());
        for (at, weight) in quadrature::points(scheme) {
            basis.add_point(&basis_jets(scheme, at), weight, &affine_chart(scheme, at));
        }
        Self { graph, scheme, basis, known: alloc::vec![None; graph.nodes.len()] }
    }

    /// The symmetric matrix of an energy over a part, row by row over the values that it depends on.
    pub(super) fn matrix(&mut self, node: u32, energy: Energy) -> Vec<f64> {
        let form = self.of(node);
        let sum =
            |i: usize| energy.bending * form.bending[i] + energy.stretching * form.stretching[i];
        let (n, transposed) = (form.size, |i: usize| i % form.size * form.size + i / form.size);
        let mut matrix: Vec<f64> =
            (0..n * n).map(|i| f64::midpoint(sum(i), sum(transposed(i)))).collect();
        // Constants have no energy, not even that of rounding.
        for (i, row) in matrix.chunks_exact_mut(n).enumerate() {
            row[i] = 0.0;
            row[i] = -row.iter().sum::<f64>();
        }
        matrix
    }

    fn of(&mut self, node: u32) -> &Form {
        if self.known[node as usize].is_none() {
            let form = match &self.graph.nodes[node as usize] {
                Node::Patch(points, _) => {
                    let mut form = Form::zero(points.source_count());
                    form.add(points, &self.basis, 1.0);
                    form
                }
                Node::Split(split) => self.of_split(split),
            };
            self.known[node as usize] = Some(form);
        }
        self.known[node as usize].as_ref().expect("it was just set")
    }

    fn of_split(&mut self, split: &Split) -> Form {
        let Some(corner) = &split.corner else { return self.of_parts(&split.parts) };
        self.with_characteristic_map(split, corner)
            .or_else(|| self.with_layout(split, corner))
            .unwrap_or_else(|| self.with_parameters(split, corner))
    }

    /// All layers towards an inner extraordinary point.
    fn with_characteristic_map(&self, split: &Split, corner: &Corner) -> Option<Form> {
        let rows = &split.parts[0].rows;
        let map = CharacteristicMap::new(rows, corner, self.scheme)?;
        let (layer, area) = self.in_map(&split.parts[1..], &map.x, &map.y)?;
        // They shrink by λ; all together are to be as large as a regular part.
        let squared = map.eigenvalue * map.eigenvalue;
        let scale = regular_area(self.scheme) * (1.0 - squared) / area;
        let steps = Square::deflated(rows, &corner.limit);
        let bending = layer.bending.iter().map(|k| k / scale).collect();
        Some(Form {
            size: layer.size,
            bending: steps.scaled(1.0 / map.eigenvalue).series(bending),
            stretching: steps.series(layer.stretching),
        })
    }

    /// The first layers, in a plane control mesh as coordinates, scaled to the area of a regular part.
    fn with_layout(&self, split: &Split, corner: &Corner) -> Option<Form> {
        let rows = &split.parts[0].rows;
        let step = |values: &[f64]| {
            let mut next = times(rows, values);
            let centre: f64 = corner.limit.iter().zip(&next).map(|(l, x)| l * x).sum();
            next.iter_mut().for_each(|x| *x -= centre);
            next
        };
        let [mut x, mut y] = layout(rows.source_count(), corner)?;
        // Where outer vertices lie follows from the inner ones.
        for _ in 0..SETTLING {
            (x, y) = (step(&x), step(&y));
        }
        let (mut layers, mut area) = (Vec::new(), 0.0);
        for _ in 0..MOST_STEPS {
            let (layer, its_area) = self.in_map(&split.parts[1..], &x, &y)?;
            layers.push(layer);
            area += its_area;
            (x, y) = (step(&x), step(&y));
        }
        let steps = Square::deflated(rows, &corner.limit);
        let mut form = Form::zero(rows.source_count());
        for layer in layers.iter().rev() {
            let add = |sum: &[f64], layer: &[f64]| {
                let mut inner = steps.pulled_back(sum);
                inner.iter_mut().zip(layer).for_each(|(sum, k)| *sum += k);
                inner
            };
            form.bending = add(&form.bending, &layer.bending);
            form.stretching = add(&form.stretching, &layer.stretching);
        }
        let scale = regular_area(self.scheme) / area;
        form.bending.iter_mut().for_each(|k| *k /= scale);
        Some(form)
    }

    /// The first layers, in the parameters of the part.
    fn with_parameters(&mut self, split: &Split, corner: &Corner) -> Form {
        let steps = Square::deflated(&split.parts[0].rows, &corner.limit);
        let layer = self.of_parts(&split.parts[1..]);
        let mut form = layer.clone();
        let add = |sum: &[f64], layer: &[f64], factor: f64| {
            let inner = steps.pulled_back(sum);
            inner.iter().zip(layer).map(|(inner, k)| factor * inner + k).collect()
        };
        for _ in 1..MOST_STEPS {
            form.bending = add(&form.bending, &layer.bending, 4.0);
            form.stretching = add(&form.stretching, &layer.stretching, 1.0);
        }
        form
    }

    /// Parts half as large as the whole, each in its own parameters.
    fn of_parts(&mut self, parts: &[Part]) -> Form {
        let mut form = Form::zero(parts[0].rows.source_count());
        for part in parts {
            form.add(&part.rows, self.of(part.node), 4.0);
        }
        form
    }

    /// The forms of regular parts in the coordinates that given control values make, and the area that
    /// they have there. `None` if parts are not regular, or fold over.
    fn in_map(&self, parts: &[Part], x: &[f64], y: &[f64]) -> Option<(Form, f64)> {
        let mut form = Form::zero(x.len());
        let mut area = 0.0;
        for part in parts {
            let Node::Patch(points, _) = &self.graph.nodes[part.node as usize] else { return None };
            let [x, y] = [x, y].map(|all| times(points, &times(&part.rows, all)));
            let mut of_points = Form::zero(x.len());
            for (at, weight) in quadrature::points(self.scheme) {
                let jets = basis_jets(self.scheme, at);
                let chart = Chart { x: combine(&jets, &x), y: combine(&jets, &y) };
                if chart.determinant() <= 0.0 {
                    return None;
                }
                area += weight * chart.determinant();
                of_points.add_point(&jets, weight, &chart);
            }
            let mut of_part = Form::zero(points.source_count());
            of_part.add(points, &of_points, 1.0);
            form.add(&part.rows, &of_part, 1.0);
        }
        Some((form, area))
    }
}

/// Two quadratic forms, row by row.
#[derive(Clone)]
struct Form {
    size: usize,
    bending: Vec<f64>,
    stretching: Vec<f64>,
}

impl Form {
    fn zero(size: usize) -> Self {
        let zero = alloc::vec![0.0; size * size];
        Self { size, bending: zero.clone(), stretching: zero }
    }

    /// Adds what forms of the results of some rows are as forms of their sources, bending times a
    /// factor.
    fn add(&mut self, rows: &Stencils, form: &Self, factor: f64) {
        let n = self.size;
        let pull = |to: &mut [f64], from: &[f64], factor: f64| {
            let mut half = alloc::vec![0.0; form.size * n];
            for (half, from) in half.chunks_exact_mut(n).zip(from.chunks_exact(form.size)) {
                for (j, k) in from.iter().enumerate() {
                    rows.row(j).for_each(|(q, w)| half[q.index()] += k * w);
                }
            }
            for (i, half) in half.chunks_exact(n).enumerate() {
                for (q, w) in rows.row(i) {
                    let to = &mut to[q.index() * n..][..n];
                    to.iter_mut().zip(half).for_each(|(to, k)| *to += factor * w * k);
                }
            }
        };
        pull(&mut self.bending, &form.bending, factor);
        pull(&mut self.stretching, &form.stretching, 1.0);
    }

    /// Adds the integrands at a point, for functions with given jets, in the coordinates of a chart.
    fn add_point(&mut self, jets: &[Jet<f64>], weight: f64, chart: &Chart) {
        let weight = weight * fabs(chart.determinant());
        let all: Vec<[f64; 5]> = jets.iter().map(|jet| chart.derivatives(jet)).collect();
        for (i, [x, y, xx, xy, yy]) in all.iter().enumerate() {
            for (j, [px, py, pxx, pxy, pyy]) in all.iter().enumerate() {
                let at = i * self.size + j;
                self.bending[at] += weight * (xx * pxx + 2.0 * xy * pxy + yy * pyy);
                self.stretching[at] += weight * (x * px + y * py);
            }
        }
    }
}

/// Coordinates of the plane as functions of the parameters of a patch, at a point.
struct Chart {
    x: Jet<f64>,
    y: Jet<f64>,
}

impl Chart {
    fn determinant(&self) -> f64 {
        self.x[1] * self.y[2] - self.x[2] * self.y[1]
    }

    /// The derivatives by $`x, y, xx, xy, yy`$ of a function with a given jet.
    fn derivatives(&self, f: &Jet<f64>) -> [f64; 5] {
        let (x, y) = (&self.x, &self.y);
        let one = 1.0 / self.determinant();
        let [ux, uy, vx, vy] = [y[2] * one, -x[2] * one, -y[1] * one, x[1] * one];
        let fx = f[1] * ux + f[2] * vx;
        let fy = f[1] * uy + f[2] * vy;
        // The second derivatives without what comes from those of the chart.
        let [uu, uv, vv] = [3, 4, 5].map(|i| f[i] - fx * x[i] - fy * y[i]);
        let second = |[ua, va]: [f64; 2], [ub, vb]: [f64; 2]| {
            uu * ua * ub + uv * (ua * vb + va * ub) + vv * va * vb
        };
        let (a, b) = ([ux, vx], [uy, vy]);
        [fx, fy, second(a, a), second(a, b), second(b, b)]
    }
}

/// The parameters themselves, for triangles as sides of an equilateral one.
fn affine_chart(scheme: Scheme, [u, v]: [f64; 2]) -> Chart {
    match scheme {
        Scheme::Loop | Scheme::Butterfly => {
            let height = sqrt(0.75);
            Chart {
                x: [u + 0.5 * v, 1.0, 0.5, 0.0, 0.0, 0.0],
                y: [height * v, 0.0, height, 0.0, 0.0, 0.0],
            }
        }
        _ => Chart { x: [u, 1.0, 0.0, 0.0, 0.0, 0.0], y: [v, 0.0, 1.0, 0.0, 0.0, 0.0] },
    }
}

fn regular_area(scheme: Scheme) -> f64 {
    match scheme {
        Scheme::Loop | Scheme::Butterfly => 0.5 * sqrt(0.75),
        _ => 1.0,
    }
}

fn basis_jets(scheme: Scheme, at: [f64; 2]) -> Vec<Jet<f64>> {
    let mut jets = Vec::new();
    let found = |_, jet| jets.push(jet);
    match scheme {
        Scheme::Loop | Scheme::Butterfly => basis::quartic(at, found),
        Scheme::CatmullClark | Scheme::Kobbelt => basis::bicubic(at, found),
        Scheme::DooSabin => basis::biquadratic(at, found),
    }
    jets
}

fn combine(jets: &[Jet<f64>], values: &[f64]) -> Jet<f64> {
    let mut sum = [0.0; 6];
    for (jet, value) in jets.iter().zip(values) {
        sum.iter_mut().zip(jet).for_each(|(sum, d)| *sum += value * d);
    }
    sum
}

fn times(rows: &Stencils, values: &[f64]) -> Vec<f64> {
    (0..rows.row_count()).map(|i| rows.row(i).map(|(q, w)| w * values[q.index()]).sum()).collect()
}

/// The two functions that a step scales by the second largest eigenvalue: in them as coordinates the
/// surface is smooth at an extraordinary point, and the rings round it are similar. \[Reif1995\]
struct CharacteristicMap {
    eigenvalue: f64,
    x: Vec<f64>,
    y: Vec<f64>,
}

impl CharacteristicMap {
    /// For inner extraordinary points without creases; `None` elsewhere.
    fn new(rows: &Stencils, corner: &Corner, scheme: Scheme) -> Option<Self> {
        let ring = smooth_ring(corner, scheme)?;
        let angle = 2.0 * core::f64::consts::PI / ring.len() as f64;
        let wave = |f: fn(f64) -> f64| {
            let weights: Vec<f64> = (0..ring.len()).map(|i| f(angle * i as f64)).collect();
            eigenfunction(rows, &corner.limit, &ring, &weights)
        };
        let ((eigenvalue, x), (_, y)) = (wave(cos)?, wave(sin)?);
        Some(Self { eigenvalue, x, y })
    }
}

/// The vertices round an inner extraordinary point.
fn smooth_ring(corner: &Corner, scheme: Scheme) -> Option<Vec<VertexId>> {
    let (topology, v): (&Topology, _) = (&corner.topology, VertexId(0));
    let sharp: Sharpness<'_> = corner.rules.sharpness(topology);
    if topology.is_boundary(v)
        || sharp.vertex(v) > 0.0
        || sharp.edges(v).any(|e| sharp.edge(e.0) > 0.0)
    {
        return None;
    }
    let ring: Vec<VertexId> = match scheme {
        Scheme::DooSabin => topology.face_vertices(FaceId(0)).to_vec(),
        _ => topology.ring(v).collect(),
    };
    (ring.len() >= 3).then_some(ring)
}

/// The faces of a sector of a boundary or crease spread evenly over a half-plane, those round the end of
/// a crease over the plane. `None` where they are fewer than regular, so that the parameters of the face
/// are good enough, and where something is sharp for a while only.
fn layout(count: usize, corner: &Corner) -> Option<[Vec<f64>; 2]> {
    use core::f64::consts::PI;
    let (topology, v) = (&corner.topology, VertexId(0));
    let sharp = corner.rules.sharpness(topology);
    let regular = match corner.rules.scheme {
        Scheme::Loop | Scheme::Butterfly => 3,
        Scheme::CatmullClark | Scheme::Kobbelt => 2,
        Scheme::DooSabin => return None,
    };
    let (ring, face_count, whole) = match sharp.kind(v, 0) {
        Kind::Smooth => {
            let ring: Vec<VertexId> = topology.ring(v).collect();
            let face_count = ring.len();
            (ring, face_count, 2)
        }
        Kind::Crease(_) | Kind::Corner => {
            let ring = Sector::new(sharp, HalfedgeId(0))?.ring(topology);
            let face_count = ring.len() - 1;
            (ring, face_count, 1)
        }
    };
    if face_count < whole * regular {
        return None;
    }
    let angle = f64::from(whole as u32) * PI / face_count as f64;
    let mut layout = [alloc::vec![0.0; count], alloc::vec![0.0; count]];
    for (i, q) in ring.iter().enumerate() {
        let at = angle * i as f64;
        [layout[0][q.index()], layout[1][q.index()]] = [cos(at), sin(at)];
    }
    Some(layout)
}

/// The eigenvalue and the values of the eigenfunction that is the first wave on a ring. Waves of one
/// frequency go to themselves, and this one shrinks least of them.
fn eigenfunction(
    rows: &Stencils,
    limit: &[f64],
    ring: &[VertexId],
    wave: &[f64],
) -> Option<(f64, Vec<f64>)> {
    const MOST: u32 = 400;
    let size: f64 = wave.iter().map(|w| w * w).sum();
    let on_ring = |values: &[f64]| -> f64 {
        ring.iter().zip(wave).map(|(v, w)| w * values[v.index()]).sum::<f64>() / size
    };
    let mut values = alloc::vec![0.0; rows.source_count()];
    ring.iter().zip(wave).for_each(|(v, &w)| values[v.index()] = w);
    for _ in 0..MOST {
        let mut next = times(rows, &values);
        // Of constants there is nothing but rounding, which would grow.
        let constant: f64 = limit.iter().zip(&next).map(|(l, x)| l * x).sum();
        next.iter_mut().for_each(|x| *x -= constant);
        let eigenvalue = on_ring(&next);
        let is_shrinking = eigenvalue > 0.0 && eigenvalue < 1.0;
        if !is_shrinking {
            return None;
        }
        next.iter_mut().for_each(|x| *x /= eigenvalue);
        let change = values.iter().zip(&next).map(|(a, b)| fabs(a - b)).fold(0.0, f64::max);
        values = next;
        if change < 1e-14 {
            return Some((eigenvalue, values));
        }
    }
    None
}

/// A square matrix, row by row.
struct Square {
    size: usize,
    entries: Vec<f64>,
}

impl Square {
    /// A step towards a corner without its action on constants, which no energy sees.
    fn deflated(rows: &Stencils, limit: &[f64]) -> Self {
        let size = rows.source_count();
        let mut entries = Vec::with_capacity(size * size);
        for i in 0..size {
            entries.extend(limit.iter().map(|l| -l));
            rows.row(i).for_each(|(q, w)| entries[i * size + q.index()] += w);
        }
        Self { size, entries }
    }

    fn scaled(&self, factor: f64) -> Self {
        let entries = self.entries.iter().map(|a| factor * a).collect();
        Self { size: self.size, entries }
    }

    fn times(&self, right: &[f64]) -> Vec<f64> {
        let n = self.size;
        let mut product = alloc::vec![0.0; n * n];
        for (to, from) in product.chunks_exact_mut(n).zip(self.entries.chunks_exact(n)) {
            for (a, row) in from.iter().zip(right.chunks_exact(n)).filter(|e| *e.0 != 0.0) {
                to.iter_mut().zip(row).for_each(|(to, b)| *to += a * b);
            }
        }
        product
    }

    /// $`A^T K A`$.
    fn pulled_back(&self, form: &[f64]) -> Vec<f64> {
        let n = self.size;
        let transposed = |m: &[f64]| (0..n * n).map(|i| m[i % n * n + i / n]).collect();
        let right = Self { size: n, entries: form.to_vec() }.times(&self.entries);
        Self { size: n, entries: transposed(&self.entries) }.times(&right)
    }

    /// $`\sum_k (A^k)^T K A^k`$, twice as many terms at a time.
    fn series(&self, mut form: Vec<f64>) -> Vec<f64> {
        const MOST: u32 = 24;
        let largest = |m: &[f64]| m.iter().fold(0.0, |most, &a| f64::max(most, fabs(a)));
        let mut power = self.scaled(1.0);
        for _ in 0..MOST {
            let rest = power.pulled_back(&form);
            form.iter_mut().zip(&rest).for_each(|(sum, k)| *sum += k);
            // The terms to come are smaller by as much again.
            if largest(&rest) <= 1e-8 * largest(&form) {
                break;
            }
            power = Self { size: self.size, entries: power.times(&power.entries) };
        }
        form
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::Parts;
    use crate::{Rules, refine, shapes};

    fn form(matrix: &[f64], a: &[f64], b: &[f64]) -> f64 {
        let row = |(k, a): (&[f64], &f64)| a * k.iter().zip(b).map(|(k, b)| k * b).sum::<f64>();
        matrix.chunks_exact(a.len()).zip(a).map(row).sum()
    }

    /// The coordinates of a characteristic map have no bending, and their stretching is the area of the
    /// map, all rings together; the sum over the rings goes to itself by a step.
    #[test]
    fn characteristic_maps_are_flat() {
        for (scheme, levels) in
            [(Scheme::Loop, 1), (Scheme::CatmullClark, 2), (Scheme::DooSabin, 3)]
        {
            for n in [3, 5, 7, 12, 30] {
                let (mesh, rules) =
                    refine::refine_mesh(&shapes::bipyramid(n), &Rules::from(scheme), levels)
                        .unwrap();
                let parts = Parts::new(mesh.topology(), &rules, 80).unwrap();
                let forms = Forms::new(&parts.graph, scheme);
                let mut found = 0;
                for node in &parts.graph.nodes {
                    let Node::Split(split) = node else { continue };
                    let Some(corner) = &split.corner else { continue };
                    if smooth_ring(corner, scheme).unwrap().len() != n as usize {
                        continue;
                    }
                    found += 1;
                    let rows = &split.parts[0].rows;
                    let map = CharacteristicMap::new(rows, corner, scheme).unwrap();
                    let cosine = cos(2.0 * core::f64::consts::PI / f64::from(n));
                    let root = sqrt((cosine + 9.0) * (cosine + 1.0));
                    let eigenvalue = match scheme {
                        Scheme::Loop => 0.375 + 0.25 * cosine,
                        Scheme::CatmullClark => (cosine + 5.0 + root) / 16.0,
                        _ => 0.5,
                    };
                    assert!((map.eigenvalue - eigenvalue).abs() < 1e-13, "{scheme} {n}");
                    let (layer, area) = forms.in_map(&split.parts[1..], &map.x, &map.y).unwrap();
                    let whole = forms.with_characteristic_map(split, corner).unwrap();
                    let area = area / (1.0 - eigenvalue * eigenvalue);
                    let scale = regular_area(scheme) / area;
                    for (a, b, expected) in
                        [(&map.x, &map.x, area), (&map.y, &map.y, area), (&map.x, &map.y, 0.0)]
                    {
                        let stretching = form(&whole.stretching, a, b);
                        assert!(
                            (stretching - expected).abs() < 1e-10 * area,
                            "{scheme} {n} {stretching} {expected}"
                        );
                        let bending = form(&whole.bending, a, b);
                        assert!(bending.abs() < 1e-8, "{scheme} {n} {bending:e}");
                    }
                    let values: Vec<f64> =
                        (0..layer.size).map(|i| sin(1.0 + 7.0 * i as f64)).collect();
                    let next = times(rows, &values);
                    let layers = form(&layer.bending, &values, &values) / scale
                        + form(&whole.bending, &next, &next) / (eigenvalue * eigenvalue);
                    let sum = form(&whole.bending, &values, &values);
                    assert!((layers - sum).abs() < 1e-9 * sum, "{scheme} {n}: {layers} {sum}");
                }
                assert!(found > 0, "{scheme} {n}");
            }
        }
    }
}
