//! Smooth subdivision surfaces through exactly the points you give.
//!
//! Approximating subdivision is fair but shrinks away from the mesh. Fairform finds the *control
//! mesh* whose limit surface passes through every vertex, on the straight line
//! faces → [`Topology`] → limit operator → solve → control mesh → refine:
//!
//! ```
//! use fairform::{Mesh, Rules, interpolate, refine, shapes};
//!
//! let target: Mesh = shapes::octahedron();
//! let options = interpolate::Options::default();
//! let (control, report) = interpolate::interpolate(&target, &Rules::LOOP, &options)?;
//! assert!(report.max <= 1e-6);
//! let (surface, _) = refine::refine_mesh(&control, &Rules::LOOP, 3)?;
//! assert_eq!(surface.topology().face_count(), 8 * 64);
//! # Ok::<(), fairform::Error>(())
//! ```
//!
//! The kernel knows no files, no clock and no screen. The same input gives the same bits, on any
//! number of threads. Source keys like \[Loop1987\] are those of `docs/references.bib`.
#![no_std]

extern crate alloc;

pub mod crease;
pub mod edit;
pub mod error;
pub mod evaluate;
pub mod faces;
pub mod fair;
pub mod fairness;
pub mod ids;
pub mod interpolate;
pub mod limit;
pub mod mesh;
pub mod onepass;
pub mod pushback;
pub mod refine;
pub mod repair;
pub mod scheme;
pub mod select;
pub mod shapes;
pub mod solve;
pub mod sphere;
pub mod stencil;
pub mod streamline;
pub mod tension;
pub mod tessellate;
pub mod topology;
pub mod vec3;

mod bspline;
mod order;
mod par;
mod parted;
mod rows;
mod rules;
mod wide;

pub use crease::Creases;
pub use error::{Defect, Defects, Error};
pub use faces::Faces;
pub use ids::{EdgeId, FaceId, HalfedgeId, NONE, VertexId};
pub use mesh::{Bounds, Mesh};
pub use scheme::{Border, Corners, Rules, Scheme};
pub use stencil::Stencils;
pub use topology::Topology;
pub use vec3::Vec3;
