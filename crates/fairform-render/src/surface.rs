//! [`Surface`]: what a surface is made of; and [`Finish`], the same in camera space.

use std::str::FromStr;

use crate::camera::Camera;
use crate::light::{dot, unit};
use crate::scene::{Vec3f, to_f32};
use crate::{Axis, RenderError};

/// What a surface is made of.
///
/// The mirrors show how curvature runs: a reflected line that has a kink tells of a jump in curvature,
/// one that is broken of a crease. They see the normals, which should therefore be exact.
///
/// Reads from text: `plain`, `zebra` or `reflection`, then the axis and the number of stripes if others
/// than `zebra,y,12` and `reflection,x,10` are wanted.
///
/// ```
/// use fairform_render::{Axis, Surface};
/// assert_eq!("zebra,z".parse(), Ok(Surface::Zebra { axis: Axis::Z, stripes: 12 }));
/// ```
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Surface {
    /// Dull, with highlights.
    #[default]
    Plain,
    /// A mirror in a world of stripes, light and dark, all equally wide, which are circles around an
    /// axis. Light stripes are nearly white, or have the colours of the body if it has its own.
    Zebra {
        /// The axis of the input that the stripes go around.
        axis: Axis,
        /// Number of dark stripes from one end of the axis to the other, 1 to 200.
        stripes: u32,
    },
    /// Lacquer in a dark studio with long soft lamps along an axis.
    Reflection {
        /// The axis of the input that the lamps lie along.
        axis: Axis,
        /// Number of lamps all around, 1 to 200.
        strips: u32,
    },
}

impl Surface {
    /// Stripes around the y axis.
    pub const ZEBRA: Self = Self::Zebra { axis: Axis::Y, stripes: 12 };
    /// Lamps along the x axis.
    pub const REFLECTION: Self = Self::Reflection { axis: Axis::X, strips: 10 };

    pub(crate) fn check(self) -> Result<(), RenderError> {
        let (what, count) = match self {
            Self::Plain => return Ok(()),
            Self::Zebra { stripes, .. } => ("the number of stripes", stripes),
            Self::Reflection { strips, .. } => ("the number of lamps", strips),
        };
        if (1..=200).contains(&count) {
            return Ok(());
        }
        Err(RenderError::Style { what, value: f64::from(count), range: "from 1 to 200" })
    }
}

/// A text is no surface.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error(
    "`{0}` is no surface: expected plain, zebra or reflection, then `,x`, `,y` or `,z` for another \
     axis and a number of stripes from 1 to 200, for example `zebra,z,20`"
)]
pub struct ParseSurfaceError(String);

impl FromStr for Surface {
    type Err = ParseSurfaceError;

    fn from_str(text: &str) -> Result<Self, ParseSurfaceError> {
        let mut parts = text.split(',').map(str::trim);
        let mut surface = match parts.next() {
            Some("plain") => Some(Self::Plain),
            Some("zebra") => Some(Self::ZEBRA),
            Some("reflection") => Some(Self::REFLECTION),
            _ => None,
        };
        for part in parts {
            let other_axis = match part {
                "x" | "X" => Some(Axis::X),
                "y" | "Y" => Some(Axis::Y),
                "z" | "Z" => Some(Axis::Z),
                _ => None,
            };
            let other_count = part.parse().ok();
            if let Some(
                Self::Zebra { axis, stripes: count } | Self::Reflection { axis, strips: count },
            ) = &mut surface
                && (other_axis.is_some() || other_count.is_some())
            {
                *axis = other_axis.unwrap_or(*axis);
                *count = other_count.unwrap_or(*count);
            } else {
                surface = None;
            }
        }
        surface
            .filter(|surface| surface.check().is_ok())
            .ok_or_else(|| ParseSurfaceError(text.chars().take(80).collect()))
    }
}

/// A [`Surface`] in camera space.
#[derive(Clone, Copy)]
pub(crate) enum Finish {
    Plain,
    Zebra {
        axis: Vec3f,
        stripes: f32,
    },
    Reflection {
        axis: Vec3f,
        /// Square to the axis: as far up as that goes, and to the side.
        across: [Vec3f; 2],
        strips: f32,
    },
}

impl Finish {
    pub(crate) fn new(surface: Surface, camera: &Camera, up: Axis) -> Self {
        match surface {
            Surface::Plain => Self::Plain,
            Surface::Zebra { axis, stripes } => {
                Self::Zebra { axis: to_f32(camera.turn(axis.direction())), stripes: stripes as f32 }
            }
            Surface::Reflection { axis, strips } => {
                let along = camera.turn(axis.direction());
                let up = camera.turn(if up == axis { axis.next() } else { up }.direction());
                let across = [up, along.cross(up)].map(to_f32);
                Self::Reflection { axis: to_f32(along), across, strips: strips as f32 }
            }
        }
    }

    /// Light, from 0 to 1, that comes back from the direction `eye` off a surface with the normal
    /// `n`; both of length one, away from the surface.
    pub(crate) fn mirrored(&self, n: Vec3f, eye: Vec3f) -> f32 {
        // An interpolated normal may point away from the eye where the surface does not.
        let slope = dot(n, eye).max(0.0);
        let r: Vec3f = std::array::from_fn(|k| 2.0 * slope * n[k] - eye[k]);
        let Some(r) = unit(r) else { return 0.0 };
        match *self {
            Self::Plain => 0.0,
            Self::Zebra { axis, stripes } => {
                let angle = libm::acosf(dot(r, axis).clamp(-1.0, 1.0));
                let at = angle / std::f32::consts::PI * stripes;
                // A dark stripe lies in the middle of each of so many parts.
                if (0.25..0.75).contains(&(at - at.floor())) { 0.0 } else { 1.0 }
            }
            Self::Reflection { axis, across, strips } => {
                studio(dot(r, axis), [dot(r, across[0]), dot(r, across[1])], strips)
            }
        }
    }
}

/// A tunnel of lamps around an axis, bright above and faint below, which ends in the dark.
fn studio(along: f32, [up, aside]: [f32; 2], strips: f32) -> f32 {
    let turn = libm::atan2f(aside, up) / std::f32::consts::TAU * strips;
    let from_middle = (turn - turn.round()).abs();
    let lamp = smooth(0.27, 0.12, from_middle);
    let above = 0.5 + 0.5 * up;
    let open = (1.0 - along * along).max(0.0).sqrt();
    let far = smooth(0.12, 0.7, open);
    let room = 0.01 + 0.04 * above * above;
    room + lamp * far * (0.1 + 0.9 * above)
}

/// From 0 at `a` to 1 at `b`, without kinks.
fn smooth(a: f32, b: f32, x: f32) -> f32 {
    let t = ((x - a) / (b - a)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// On a mirror ball seen from afar, the stripes around the axis of sight.
    #[test]
    fn stripes_are_equally_wide() {
        let zebra = Finish::Zebra { axis: [0.0, 0.0, -1.0], stripes: 6.0 };
        let eye = [0.0, 0.0, -1.0];
        // The mirror turns twice as far as its normal.
        let light = |i: u16| {
            let angle = 0.5 * std::f32::consts::PI * (f32::from(i) + 0.5) / 600.0;
            zebra.mirrored([libm::sinf(angle), 0.0, -libm::cosf(angle)], eye)
        };
        let changes: Vec<u16> = (1..600).filter(|&i| light(i) != light(i - 1)).collect();
        assert_eq!(changes.len(), 12);
        for pair in changes.windows(2) {
            assert!((49..=51).contains(&(pair[1] - pair[0])), "{changes:?}");
        }
    }

    /// Smooth lamps on a dark ground, everywhere.
    #[test]
    fn the_studio_has_no_jumps() {
        for axis in 0..40 {
            let along = -1.0 + 2.0 * (axis as f32 + 0.5) / 40.0;
            let open = (1.0_f32 - along * along).sqrt();
            let at = |i: u16| {
                let t = std::f32::consts::TAU * f32::from(i) / 4000.0;
                studio(along, [open * libm::cosf(t), open * libm::sinf(t)], 10.0)
            };
            for i in 0..4000 {
                assert!((at(i) - at(i + 1)).abs() < 0.06 && (0.0..=1.2).contains(&at(i)));
            }
        }
        let middle = studio(0.0, [1.0, 0.0], 10.0);
        let between = studio(0.0, [libm::cosf(0.314), libm::sinf(0.314)], 10.0);
        assert!(middle > 0.9 && between < 0.15, "{middle} {between}");
    }

    #[test]
    fn surfaces_are_read() {
        assert_eq!("plain".parse(), Ok(Surface::Plain));
        assert_eq!("zebra".parse(), Ok(Surface::ZEBRA));
        let lamps = Surface::Reflection { axis: Axis::Z, strips: 7 };
        assert_eq!("reflection, 7, Z".parse(), Ok(lamps));
        for text in
            ["", "mirror", "plain,x", "zebra,w", "zebra,0", "zebra,201", "zebra,-1", "zebra,"]
        {
            assert!(text.parse::<Surface>().is_err(), "{text}");
        }
    }
}
