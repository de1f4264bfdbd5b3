//! Fairness of a surface as numbers: curvature, energies, deviation from the mesh it was made for.
//!
//! The input is a finely sampled surface: usually a subdivision surface refined a few times, its
//! vertices moved to the limit, with the normals of [`limit_normals`](crate::limit::limit_normals).
//!
//! ```
//! use fairform::{Rules, fairness, limit, refine, shapes};
//!
//! let (control, rules) = refine::refine_mesh(&shapes::icosahedron(), &Rules::LOOP, 3)?;
//! let (net, points) = (control.topology(), control.positions());
//! let positions = limit::limit_points(net, points, &rules)?;
//! let normals = limit::limit_normals(net, points, &rules)?;
//! let curvatures = fairness::curvatures(net, &positions, &normals);
//! let measures = fairness::measures(net, &positions, &curvatures);
//! // Nearly a sphere, of which this is 4π.
//! assert!((measures.willmore / 12.566 - 1.0).abs() < 0.02);
//! # Ok::<(), fairform::Error>(())
//! ```
//!
//! **Signs.** Curvature is positive where the surface bends away from its normal: a sphere of
//! radius `r` with outward normals has both principal curvatures, and so `H`, equal to $`1/r`$.
//!
//! **Bad input.** Nothing here panics for what the numbers are. What is undefined is zero: the
//! curvature at isolated vertices and where all neighbours coincide, the integrals over faces
//! without area or with a coordinate that is not finite. What would leave the range of `f64` is
//! [`f64::MAX`]. Normals that are zero or not finite are replaced by
//! [`fitted_normals`].

mod curvature;
mod distance;
mod fit;
mod frame;
mod measures;
mod normals;
mod undulation;

pub use curvature::{Curvature, curvatures};
pub use distance::{Deviation, deviation, distances, mutual_deviation, samples};
pub(crate) use distance::{square_to_segment, square_to_triangle};
pub use measures::{Measures, PERCENTILES, measures};
pub(crate) use normals::face_normal;
pub use normals::{fitted_normals, vertex_normals};
pub use undulation::{Undulation, undulation};
