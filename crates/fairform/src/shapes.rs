//! Small meshes with known answers, and regular ones of any size.

use alloc::vec::Vec;
use core::f64::consts::PI;

use libm::{cos, sin, sqrt};

use crate::{Faces, Mesh, Vec3};

fn mesh(positions: &[[f64; 3]], faces: &Faces) -> Mesh {
    let positions = positions.iter().map(|&p| p.into()).collect();
    Mesh::new(positions, faces).expect("the shape is a manifold")
}

/// The regular tetrahedron: all valences 3.
#[must_use]
pub fn tetrahedron() -> Mesh {
    mesh(
        &[[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]],
        &Faces::uniform(3, alloc::vec![0, 1, 2, 0, 3, 1, 0, 2, 3, 1, 3, 2]),
    )
}

/// The regular octahedron: all valences 4, and 3-colourable.
#[must_use]
pub fn octahedron() -> Mesh {
    mesh(
        &[
            [1.0, 0.0, 0.0],
            [-1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, -1.0, 0.0],
            [0.0, 0.0, 1.0],
            [0.0, 0.0, -1.0],
        ],
        &Faces::uniform(
            3,
            alloc::vec![0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5],
        ),
    )
}

/// The regular icosahedron: all valences 5.
#[must_use]
pub fn icosahedron() -> Mesh {
    let g = f64::midpoint(1.0, sqrt(5.0));
    mesh(
        &[
            [-1.0, g, 0.0],
            [1.0, g, 0.0],
            [-1.0, -g, 0.0],
            [1.0, -g, 0.0],
            [0.0, -1.0, g],
            [0.0, 1.0, g],
            [0.0, -1.0, -g],
            [0.0, 1.0, -g],
            [g, 0.0, -1.0],
            [g, 0.0, 1.0],
            [-g, 0.0, -1.0],
            [-g, 0.0, 1.0],
        ],
        &Faces::uniform(
            3,
            alloc::vec![
                0, 11, 5, 0, 5, 1, 0, 1, 7, 0, 7, 10, 0, 10, 11, 1, 5, 9, 5, 11, 4, 11, 10, 2, 10,
                7, 6, 7, 1, 8, 3, 9, 4, 3, 4, 2, 3, 2, 6, 3, 6, 8, 3, 8, 9, 4, 9, 5, 2, 4, 11, 6,
                2, 10, 8, 6, 7, 9, 8, 1,
            ],
        ),
    )
}

/// The unit cube with the given face list of six quadrilaterals, outwards.
#[must_use]
pub fn cube() -> Mesh {
    let corner = |i: u32| [0, 1, 2].map(|axis| f64::from(i >> axis & 1));
    let positions: Vec<[f64; 3]> = (0..8).map(corner).collect();
    mesh(
        &positions,
        &Faces::uniform(
            4,
            alloc::vec![0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5],
        ),
    )
}

/// A torus of `rows × columns` vertices, each of valence 6: radii 1 and 0.4, axis z.
///
/// # Panics
/// If there are fewer than 3 rows or columns.
#[must_use]
pub fn torus(rows: u32, columns: u32) -> Mesh {
    assert!(rows >= 3 && columns >= 3, "a torus has at least 3 rows and columns");
    let at = |i: u32, j: u32| i % rows * columns + j % columns;
    let mut corners = Vec::with_capacity(6 * (rows * columns) as usize);
    let mut positions = Vec::with_capacity((rows * columns) as usize);
    for i in 0..rows {
        let u = 2.0 * PI * f64::from(i) / f64::from(rows);
        for j in 0..columns {
            let v = 2.0 * PI * f64::from(j) / f64::from(columns);
            let r = 1.0 + 0.4 * cos(v);
            positions.push(Vec3::new(r * cos(u), r * sin(u), 0.4 * sin(v)));
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            corners.extend([a, b, c, a, c, d]);
        }
    }
    Mesh::new(positions, &Faces::uniform(3, corners)).expect("a torus is a manifold")
}

/// An open sheet of `rows × columns` vertices over the unit square: heights by `f(x, y)`, inner
/// valence 6.
///
/// # Panics
/// If there are fewer than 2 rows or columns.
#[must_use]
pub fn sheet(rows: u32, columns: u32, f: impl Fn(f64, f64) -> f64) -> Mesh {
    assert!(rows >= 2 && columns >= 2, "a sheet has at least 2 rows and columns");
    let mut positions = Vec::with_capacity((rows * columns) as usize);
    let mut corners = Vec::with_capacity(6 * ((rows - 1) * (columns - 1)) as usize);
    for i in 0..rows {
        for j in 0..columns {
            let x = f64::from(j) / f64::from(columns - 1);
            let y = f64::from(i) / f64::from(rows - 1);
            positions.push(Vec3::new(x, y, f(x, y)));
            if i + 1 < rows && j + 1 < columns {
                let a = i * columns + j;
                let (b, c, d) = (a + 1, a + columns + 1, a + columns);
                corners.extend([a, b, c, a, c, d]);
            }
        }
    }
    Mesh::new(positions, &Faces::uniform(3, corners)).expect("a sheet is a manifold")
}

/// An open tube of `rings` rings of `around` vertices, about the z axis, radius 1, height 2.
///
/// # Panics
/// If there are fewer than 2 rings or 3 vertices around.
#[must_use]
pub fn tube(rings: u32, around: u32) -> Mesh {
    assert!(rings >= 2 && around >= 3, "a tube has at least 2 rings of 3 vertices");
    let mut positions = Vec::new();
    let mut corners = Vec::new();
    for i in 0..rings {
        for j in 0..around {
            let u = 2.0 * PI * f64::from(j) / f64::from(around);
            let z = 2.0 * f64::from(i) / f64::from(rings - 1) - 1.0;
            positions.push(Vec3::new(cos(u), sin(u), z));
            if i + 1 < rings {
                let (a, b) = (i * around + j, i * around + (j + 1) % around);
                corners.extend([a, b, b + around, a, b + around, a + around]);
            }
        }
    }
    Mesh::new(positions, &Faces::uniform(3, corners)).expect("a tube is a manifold")
}

/// Two cones of `n` triangles glued together: poles of valence `n` round an equator of valence 4.
///
/// # Panics
/// If `n < 3`.
#[must_use]
pub fn bipyramid(n: u32) -> Mesh {
    assert!(n >= 3, "a bipyramid has at least 3 sides");
    let mut positions: Vec<Vec3> = (0..n)
        .map(|i| 2.0 * PI * f64::from(i) / f64::from(n))
        .map(|u| Vec3::new(cos(u), sin(u), 0.0))
        .collect();
    positions.push(Vec3::new(0.0, 0.0, 1.0));
    positions.push(Vec3::new(0.0, 0.0, -1.0));
    let faces: Faces = (0..n)
        .flat_map(|i| {
            let j = (i + 1) % n;
            [[i, j, n], [j, i, n + 1]]
        })
        .collect();
    Mesh::new(positions, &faces).expect("a bipyramid is a manifold")
}

/// A disk of `n` triangles round one inner vertex of valence `n`, slightly conical.
///
/// # Panics
/// If `n < 3`.
#[must_use]
pub fn fan(n: u32) -> Mesh {
    assert!(n >= 3, "a fan has at least 3 triangles");
    let mut positions: Vec<Vec3> = (0..n)
        .map(|i| 2.0 * PI * f64::from(i) / f64::from(n))
        .map(|u| Vec3::new(cos(u), sin(u), 0.1 * cos(3.0 * u)))
        .collect();
    positions.push(Vec3::new(0.0, 0.0, 0.5));
    let faces: Faces = (0..n).map(|i| [i, (i + 1) % n, n]).collect();
    Mesh::new(positions, &faces).expect("a fan is a manifold")
}
