//! Unit tangents: points of the Gaussian sphere, their blends, means and subdivision.
//!
//! A direction is a [`Vec3`] of length one. Two of them are blended along their great circle
//! ([`blend`]), several of them pair by pair ([`combine`]) or as a spherical mean ([`mean()`]); what
//! linear schemes do with sums, the same schemes do here with blends: on sequences ([`Step`]), grids
//! ([`streamline`](crate::streamline)) and meshes ([`refine_tangents`]). Turning all directions turns
//! every result. \[Miura2001\]
//!
//! ```
//! use fairform::Vec3;
//! use fairform::sphere::{Ends, Rule, Step};
//!
//! let quarter = [Vec3::new(1.0, 0.0, 0.0), Vec3::new(0.6, 0.8, 0.0), Vec3::new(0.0, 1.0, 0.0)];
//! let finer = Step::new(Rule::Chaikin, Ends::Natural, 3)?.directions(&quarter);
//! assert_eq!(finer.len(), 4);
//! assert!(finer.iter().all(|t| (t.length() - 1.0).abs() < 1e-15));
//! # Ok::<(), fairform::sphere::Error>(())
//! ```

use crate::Vec3;

mod blend;
mod combine;
mod error;
mod mean;
mod mesh;
mod qi;
mod step;

pub use blend::{angle, blend, carry, midpoint, rotated, weighted, with_component};
pub use combine::combine;
pub use error::Error;
pub use mean::{exp, log, mean, weighted_mean};
pub use mesh::{MeshOptions, refine_parameters, refine_tangents};
pub use qi::{Knots, QiCurve};
pub use step::{Ends, Rule, Step, Terms};

/// How far from one the length of a given direction may be. Files round.
pub const UNIT_TOLERANCE: f64 = 1e-6;

/// Which blend makes one direction of several.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Blend {
    /// Pairs, recursively: [`combine`]. As published.
    #[default]
    Pairs,
    /// The weighted spherical mean: [`weighted_mean`].
    Mean,
}

/// Whether a length is one, as files have it; NaN is not.
pub(crate) fn is_unit(length: f64) -> bool {
    (length - 1.0).abs() <= UNIT_TOLERANCE
}

/// The directions scaled to length one to the last bit.
///
/// # Errors
/// [`Error::NotUnit`] for one that is longer or shorter by more than [`UNIT_TOLERANCE`].
pub fn unit(tangents: &mut [Vec3]) -> Result<(), Error> {
    for (index, t) in tangents.iter_mut().enumerate() {
        let length = t.length();
        if !is_unit(length) {
            return Err(Error::NotUnit { index, length });
        }
        if (length - 1.0).abs() > 1e-15 {
            *t = t.normalized();
        }
    }
    Ok(())
}

/// The pairs of neighbours `(i, i + 1)` that point in opposite directions, so that any great circle
/// through them is as good: legitimate, but worth a warning.
#[must_use]
pub fn antipodal_neighbours(tangents: &[Vec3]) -> alloc::vec::Vec<usize> {
    let pairs = tangents.windows(2).enumerate();
    pairs.filter(|(_, pair)| blend::is_antipodal(pair[0], pair[1])).map(|(i, _)| i).collect()
}
