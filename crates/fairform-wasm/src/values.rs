//! [`Values`]: what a surface is coloured by.

use std::str::FromStr;

use fairform::fairness::Curvature;

use crate::Problem;

/// What a surface can be coloured by.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Colouring {
    /// Gaussian curvature.
    Gaussian,
    /// Mean curvature.
    Mean,
    /// The larger of the absolute principal curvatures.
    MaxAbs,
    /// Distance of the surface from the vertices.
    Error,
    /// Shape parameters.
    Tension,
    /// Distance from the given mesh.
    Deviation,
}

impl FromStr for Colouring {
    type Err = Problem;

    fn from_str(name: &str) -> Result<Self, Problem> {
        Ok(match name {
            "gaussian" => Self::Gaussian,
            "mean" => Self::Mean,
            "max-abs" => Self::MaxAbs,
            "error" => Self::Error,
            "tension" => Self::Tension,
            "deviation" => Self::Deviation,
            _ => return Err(Problem::new(format!("nothing is coloured by {name:?}"))),
        })
    }
}

impl Colouring {
    /// The value of a curvature; none if it is about something else.
    pub(crate) fn of_curvature(self, curvature: &Curvature) -> Option<f64> {
        let [k1, k2] = curvature.principal;
        match self {
            Self::Gaussian => Some(curvature.gaussian()),
            Self::Mean => Some(curvature.mean()),
            Self::MaxAbs => Some(k1.abs().max(k2.abs())),
            _ => None,
        }
    }

    fn label(self) -> &'static str {
        match self {
            Self::Gaussian => "Gaussian curvature, 1/length²",
            Self::Mean => "Mean curvature, 1/length",
            Self::MaxAbs => "Largest absolute curvature, 1/length",
            Self::Error => "Distance from the vertices, of the diagonal",
            Self::Tension => "Shape parameter λ",
            Self::Deviation => "Distance from the given mesh, length",
        }
    }
}

/// One value per vertex of a surface.
#[derive(Clone, PartialEq, Debug)]
pub struct Values {
    /// The values.
    pub values: Vec<f32>,
    /// The lower end of a range that shows most of them.
    pub low: f64,
    /// The upper end.
    pub high: f64,
    /// What they are.
    pub label: &'static str,
}

/// The share of the values that may lie beyond each end of the range.
const BEYOND: f64 = 0.02;

impl Values {
    /// Values with a range between percentiles: about zero where the sign matters, from zero for distances.
    pub(crate) fn new(colouring: Colouring, values: &[f64]) -> Self {
        let mut sorted: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
        let last = sorted.len().saturating_sub(1) as f64;
        let mut at = |share: f64| {
            if sorted.is_empty() {
                return 0.0;
            }
            let (_, value, _) =
                sorted.select_nth_unstable_by((share * last).round() as usize, f64::total_cmp);
            *value
        };
        let (low, high) = (at(BEYOND), at(1.0 - BEYOND));
        let [low, high] = match colouring {
            Colouring::Gaussian | Colouring::Mean => {
                let most = low.abs().max(high.abs());
                [-most, most]
            }
            Colouring::Tension => [at(0.0), at(1.0)],
            _ => [0.0, high],
        };
        let single = values.iter().map(|&v| v as f32).collect();
        Self { values: single, low, high, label: colouring.label() }
    }
}
