//! [`Elements`]: the energy of the limit surface of a mesh, part by part.

use alloc::vec::Vec;

use super::Energy;
use super::forms::Forms;
use crate::error::Error;
use crate::evaluate::Parts;
use crate::ids::NONE;
use crate::{Rules, Topology, Vec3, par};

/// Most faces round a part that counts, so that all is linear in the size of the mesh.
const MOST_FACES: u32 = 80;

/// An energy of the limit surface as a sum over the parts of the surface. Alike parts share a matrix.
pub(super) struct Elements {
    parts: Parts,
    /// By node; empty if no part is such.
    matrices: Vec<Vec<f64>>,
    /// For each vertex the parts that depend on it, and its place there.
    start: Vec<u32>,
    part: Vec<u32>,
    place: Vec<u8>,
}

impl Elements {
    pub(super) fn new(topology: &Topology, rules: &Rules, energy: Energy) -> Result<Self, Error> {
        let parts = Parts::new(topology, rules, MOST_FACES)?;
        let mut forms = Forms::new(&parts.graph, rules.scheme);
        let mut matrices = alloc::vec![Vec::new(); parts.graph.nodes.len()];
        for &node in parts.node.iter().filter(|&&node| node != NONE) {
            if matrices[node as usize].is_empty() {
                matrices[node as usize] = forms.matrix(node, energy);
            }
        }
        let mut start = alloc::vec![0; topology.vertex_count() + 1];
        parts.vertices.iter().for_each(|v| start[v.index() + 1] += 1);
        for v in 0..topology.vertex_count() {
            start[v + 1] += start[v];
        }
        let mut end = start.clone();
        let mut part = alloc::vec![0; parts.vertices.len()];
        let mut place = alloc::vec![0; parts.vertices.len()];
        for i in 0..parts.node.len() {
            for (k, v) in parts.vertices(i).iter().enumerate() {
                let at = &mut end[v.index()];
                part[*at as usize] = i as u32;
                // A face adds two values at most.
                place[*at as usize] = k as u8;
                *at += 1;
            }
        }
        Ok(Self { parts, matrices, start, part, place })
    }

    /// The energy for values at the vertices.
    pub(super) fn energy(&self, x: &[Vec3]) -> f64 {
        let blocks = par::blocks(self.parts.node.len(), |range| {
            range.map(|part| self.of_part(part, x)).sum::<f64>()
        });
        blocks.into_iter().sum()
    }

    fn of_part(&self, part: usize, x: &[Vec3]) -> f64 {
        let vertices = self.parts.vertices(part);
        let Some(base) = vertices.first().map(|v| x[v.index()]) else { return 0.0 };
        let matrix = &self.matrices[self.parts.node[part] as usize];
        let row = |(k, v): (usize, &crate::VertexId)| {
            let row = &matrix[k * vertices.len()..][..vertices.len()];
            let image: Vec3 =
                row.iter().zip(vertices).map(|(&w, q)| w * (x[q.index()] - base)).sum();
            (x[v.index()] - base).dot(image)
        };
        vertices.iter().enumerate().map(row).sum()
    }

    /// Half of how the energy changes with the values: a symmetric operator. One thread gathers all
    /// that a vertex gets.
    pub(super) fn gradient(&self, x: &[Vec3]) -> Vec<Vec3> {
        par::collect(x.len(), |v| {
            let mut sum = Vec3::ZERO;
            for (row, vertices) in self.rows(v) {
                // Differences, since constants have no energy: so they keep their digits.
                for (&w, q) in row.iter().zip(vertices) {
                    sum += w * (x[q.index()] - x[v]);
                }
            }
            sum
        })
    }

    /// The diagonal of that operator.
    pub(super) fn diagonal(&self) -> Vec<f64> {
        par::collect(self.start.len() - 1, |v| {
            self.entries(v)
                .map(|i| {
                    let (row, _) = self.row(i);
                    row[self.place[i] as usize]
                })
                .sum()
        })
    }

    fn entries(&self, v: usize) -> core::ops::Range<usize> {
        self.start[v] as usize..self.start[v + 1] as usize
    }

    fn rows(&self, v: usize) -> impl Iterator<Item = (&[f64], &[crate::VertexId])> {
        self.entries(v).map(|i| self.row(i))
    }

    fn row(&self, i: usize) -> (&[f64], &[crate::VertexId]) {
        let part = self.part[i] as usize;
        let vertices = self.parts.vertices(part);
        let matrix = &self.matrices[self.parts.node[part] as usize];
        (&matrix[self.place[i] as usize * vertices.len()..][..vertices.len()], vertices)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Faces, Mesh, Scheme, VertexId, refine, shapes};
    use libm::{cos, sin, sqrt};

    const BOTH: [Energy; 2] =
        [Energy { bending: 1.0, stretching: 0.0 }, Energy { bending: 0.0, stretching: 1.0 }];

    /// A torus of squares, and the place of each vertex in the lattice. The first faces are apart and
    /// reach all vertices, which are numbered by them, as images of faces are.
    fn quad_torus(rows: u32, columns: u32) -> (Mesh, Vec<[u32; 2]>) {
        const CORNERS: [[u32; 2]; 4] = [[0, 0], [0, 1], [1, 1], [1, 0]];
        let places: Vec<[u32; 2]> = (0..rows * columns)
            .map(|k| {
                let (block, [i, j]) = (k / 4, CORNERS[k as usize % 4]);
                [2 * (block / (columns / 2)) + i, 2 * (block % (columns / 2)) + j]
            })
            .collect();
        let at = |i: u32, j: u32| {
            places.iter().position(|p| *p == [i % rows, j % columns]).unwrap() as u32
        };
        let face = |[i, j]: [u32; 2]| CORNERS.map(|[a, b]| at(i + a, j + b));
        let (first, others): (Vec<_>, Vec<_>) =
            places.iter().partition(|[i, j]| i % 2 == 0 && j % 2 == 0);
        let corners = first.into_iter().chain(others).flat_map(face).collect();
        let points = alloc::vec![Vec3::ZERO; places.len()];
        (Mesh::new(points, &Faces::uniform(4, corners)).unwrap(), places)
    }

    /// On a periodic lattice a wave is an eigenfunction, and its eigenvalue is made of the inner
    /// products of B-splines and of their derivatives, which are B-splines themselves.
    #[test]
    fn tensor_splines_have_the_energy_of_their_inner_products() {
        let cubic: [&[f64]; 3] = [
            &[151.0 / 315.0, 397.0 / 1680.0, 1.0 / 42.0, 1.0 / 5040.0],
            &[2.0 / 3.0, -1.0 / 8.0, -1.0 / 5.0, -1.0 / 120.0],
            &[8.0 / 3.0, -3.0 / 2.0, 0.0, 1.0 / 6.0],
        ];
        let quadratic: [&[f64]; 3] = [
            &[11.0 / 20.0, 13.0 / 60.0, 1.0 / 120.0],
            &[1.0, -1.0 / 3.0, -1.0 / 6.0],
            &[6.0, -4.0, 1.0],
        ];
        let (mesh, places) = quad_torus(8, 10);
        let angles = [2.0 * core::f64::consts::PI / 8.0, 6.0 * core::f64::consts::PI / 10.0];
        for (scheme, products) in [(Scheme::CatmullClark, cubic), (Scheme::DooSabin, quadratic)] {
            let symbol = |order: usize, angle: f64| -> f64 {
                let waves = products[order].iter().enumerate();
                let twice = |k: usize| if k == 0 { 1.0 } else { 2.0 };
                waves.map(|(k, p)| twice(k) * p * cos(k as f64 * angle)).sum()
            };
            let [u, v] = angles;
            let expected = [
                symbol(2, u) * symbol(0, v)
                    + 2.0 * symbol(1, u) * symbol(1, v)
                    + symbol(0, u) * symbol(2, v),
                symbol(1, u) * symbol(0, v) + symbol(0, u) * symbol(1, v),
            ];
            let wave = |&[i, j]: &[u32; 2]| cos(f64::from(i) * u + f64::from(j) * v);
            let x: Vec<Vec3> = places.iter().map(|p| Vec3::new(wave(p), 0.0, 0.0)).collect();
            for (energy, expected) in BOTH.into_iter().zip(expected) {
                let elements =
                    Elements::new(mesh.topology(), &Rules::from(scheme), energy).unwrap();
                let gradient = elements.gradient(&x);
                for (g, x) in gradient.iter().zip(&x) {
                    assert!((g.x - expected * x.x).abs() < 1e-13, "{scheme} {energy:?}");
                }
                assert!((elements.energy(&x) / (40.0 * expected) - 1.0).abs() < 1e-13);
            }
        }
    }

    /// The box spline of a quadratic polynomial is that polynomial and a constant.
    #[test]
    fn box_splines_have_the_energy_of_quadratic_polynomials() {
        let mesh = shapes::sheet(7, 8, |_, _| 0.0);
        let topology = mesh.topology();
        // To sides of length 1, as far apart as in an equilateral triangle.
        let face = topology.face_vertices(crate::FaceId(0));
        let grid = |v: VertexId| {
            let p = mesh.positions()[v.index()];
            let [a, b] = [p.x, p.y].map(|t| libm::round(t * 1000.0) / 1000.0);
            (a, b)
        };
        let size = |of: fn((f64, f64)) -> f64| {
            let values: Vec<f64> = face.iter().map(|&v| of(grid(v))).collect();
            values.iter().fold(0.0, |most: f64, v| most.max((v - values[0]).abs()))
        };
        let (du, dv) = (size(|p| p.0), size(|p| p.1));
        let place = |v: VertexId, slant: f64| {
            let p = mesh.positions()[v.index()];
            let (i, j) = (libm::round(p.x / du), libm::round(p.y / dv));
            [i + slant * j, sqrt(0.75) * j]
        };
        let is_equilateral = |slant: f64| {
            let [a, b, c] = [0, 1, 2].map(|i| place(face[i], slant));
            let length = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
            [length(a, b), length(b, c), length(c, a)].iter().all(|l| (l - 1.0).abs() < 1e-12)
        };
        let slant = [0.5, -0.5].into_iter().find(|&s| is_equilateral(s)).unwrap();
        let f = |[x, y]: [f64; 2]| 0.7 * x * x - 0.4 * x * y + 0.3 * y * y + x - 2.0 * y;
        let slopes = |[x, y]: [f64; 2]| [1.4 * x - 0.4 * y + 1.0, -0.4 * x + 0.6 * y - 2.0];
        let values: Vec<Vec3> =
            topology.vertices().map(|v| Vec3::new(0.0, f(place(v, slant)), 0.0)).collect();
        let mut found = 0;
        for (energy, is_bending) in BOTH.into_iter().zip([true, false]) {
            let elements = Elements::new(topology, &Rules::LOOP, energy).unwrap();
            for part in 0..topology.face_count() {
                let corners = topology.face_vertices(crate::FaceId(part as u32));
                let is_inner = |v: &VertexId| {
                    let ring: Vec<VertexId> = topology.ring(*v).collect();
                    !topology.is_boundary(*v) && ring.iter().all(|&q| !topology.is_boundary(q))
                };
                if !corners.iter().all(is_inner) {
                    continue;
                }
                found += 1;
                let area = sqrt(0.75) / 2.0;
                let expected = if is_bending {
                    area * (1.4 * 1.4 + 2.0 * 0.4 * 0.4 + 0.6 * 0.6)
                } else {
                    // The rule of the middles of the sides is exact.
                    let middles = [(0, 1), (1, 2), (2, 0)].map(|(i, j)| {
                        let [a, b] = [corners[i], corners[j]].map(|v| place(v, slant));
                        let [x, y] = slopes([0, 1].map(|k| f64::midpoint(a[k], b[k])));
                        x * x + y * y
                    });
                    area / 3.0 * middles.iter().sum::<f64>()
                };
                let actual = elements.of_part(part, &values);
                assert!((actual / expected - 1.0).abs() < 1e-11, "{part}: {actual} {expected}");
            }
        }
        assert!(found > 4);
    }

    /// $`\langle Kx, y \rangle = \langle x, Ky \rangle`$, the energy is $`\langle x, Kx \rangle`$ and not
    /// negative, and constants have none.
    #[test]
    fn the_gradient_is_symmetric_and_that_of_the_energy() {
        let dot = |a: &[Vec3], b: &[Vec3]| -> f64 { a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum() };
        for mesh in
            [shapes::icosahedron(), shapes::fan(9), shapes::bipyramid(20), shapes::tube(4, 5)]
        {
            for scheme in [Scheme::Loop, Scheme::CatmullClark, Scheme::DooSabin] {
                let (mesh, rules) = refine::refine_mesh(&mesh, &Rules::from(scheme), 1).unwrap();
                let energy = Energy { bending: 1.0, stretching: 0.3 };
                let elements = Elements::new(mesh.topology(), &rules, energy).unwrap();
                let value = |i: usize, a: f64| {
                    Vec3::new(sin(a * i as f64), cos(a * i as f64), sin(1.0 + i as f64))
                };
                let count = mesh.positions().len();
                let [x, y] =
                    [2.3, 5.1].map(|a| (0..count).map(|i| value(i, a)).collect::<Vec<_>>());
                let (kx, ky) = (elements.gradient(&x), elements.gradient(&y));
                let (a, b) = (dot(&kx, &y), dot(&x, &ky));
                let size = elements.energy(&x);
                assert!(size > 0.0 && (a - b).abs() < 1e-12 * size, "{scheme}: {a} {b}");
                let product = dot(&x, &kx);
                assert!((product / size - 1.0).abs() < 1e-12, "{scheme} {product} {size}");
                let constant = alloc::vec![Vec3::new(3.0, 1.0, 2.0); count];
                assert!(elements.energy(&constant) == 0.0, "{scheme}");
                assert!(elements.gradient(&constant).iter().all(|g| *g == Vec3::ZERO));
            }
        }
    }
}
