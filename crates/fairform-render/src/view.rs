//! [`View`]: where the picture is taken from.

use std::str::FromStr;

use fairform::Vec3;

use crate::RenderError;

/// A coordinate axis.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Axis {
    /// First coordinate.
    X,
    /// Second coordinate.
    #[default]
    Y,
    /// Third coordinate.
    Z,
}

impl Axis {
    pub(crate) fn direction(self) -> Vec3 {
        match self {
            Self::X => Vec3::new(1., 0., 0.),
            Self::Y => Vec3::new(0., 1., 0.),
            Self::Z => Vec3::new(0., 0., 1.),
        }
    }

    pub(crate) fn next(self) -> Self {
        match self {
            Self::X => Self::Y,
            Self::Y => Self::Z,
            Self::Z => Self::X,
        }
    }
}

/// Where the picture is taken from. The camera stands so far away that all bodies are in the frame.
///
/// Reads from text: `front`, `back`, `left`, `right`, `top`, `bottom`, `iso` or `AZIMUTH,ELEVATION`
/// in degrees, then `,x`, `,y` or `,z` if another axis than y is up.
///
/// ```
/// use fairform_render::{Axis, View};
/// assert_eq!("iso".parse(), Ok(View::default()));
/// assert_eq!("30,20,z".parse(), Ok(View { azimuth: 30., elevation: 20., up: Axis::Z, ..View::default() }));
/// ```
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct View {
    /// How far the camera has walked around the up axis, in degrees: 0 is in front (towards +z when
    /// y is up, towards −y when z is up), 90 at the right (+x).
    pub azimuth: f64,
    /// How far it has climbed, in degrees from −90 (below) to 90 (above).
    pub elevation: f64,
    /// The axis that is up in the picture.
    pub up: Axis,
    /// Magnification: 1 fits all bodies into the frame, 2 shows them twice as large, cropped.
    pub zoom: f64,
    /// Vertical opening of the lens in degrees, from 1 (nearly parallel) to 120.
    pub field: f64,
}

impl Default for View {
    /// A three-quarter view from the right and a little above, y up, with a long lens.
    fn default() -> Self {
        Self { azimuth: 35.0, elevation: 20.0, up: Axis::Y, zoom: 1.0, field: 24.0 }
    }
}

impl View {
    /// Right, up and towards the camera, as unit vectors.
    pub(crate) fn axes(&self) -> [Vec3; 3] {
        let (front, side, up) = match self.up {
            Axis::X => (Vec3::new(0., 0., 1.), Vec3::new(0., -1., 0.), Vec3::new(1., 0., 0.)),
            Axis::Y => (Vec3::new(0., 0., 1.), Vec3::new(1., 0., 0.), Vec3::new(0., 1., 0.)),
            Axis::Z => (Vec3::new(0., -1., 0.), Vec3::new(1., 0., 0.), Vec3::new(0., 0., 1.)),
        };
        let (sin_a, cos_a) = turn(self.azimuth);
        let (sin_e, cos_e) = turn(self.elevation);
        let level = cos_a * front + sin_a * side;
        [cos_a * side - sin_a * front, cos_e * up - sin_e * level, cos_e * level + sin_e * up]
    }

    pub(crate) fn check(&self) -> Result<(), RenderError> {
        let wrong = |what, value, range| Err(RenderError::View { what, value, range });
        if !self.azimuth.is_finite() {
            return wrong("azimuth", self.azimuth, "a finite number of degrees");
        }
        if !(-90.0..=90.0).contains(&self.elevation) {
            return wrong("elevation", self.elevation, "from -90 to 90 degrees");
        }
        if !(1e-3..=1e6).contains(&self.zoom) {
            return wrong("zoom", self.zoom, "from 0.001 to 1000000");
        }
        if !(1.0..=120.0).contains(&self.field) {
            return wrong("field", self.field, "from 1 to 120 degrees");
        }
        Ok(())
    }
}

/// Sine and cosine of an angle in degrees, exact at the quarters.
fn turn(degrees: f64) -> (f64, f64) {
    let d = degrees % 360.0;
    let quarter = (d / 90.0).round();
    let rest = (d - 90.0 * quarter).to_radians();
    let (s, c) = (libm::sin(rest), libm::cos(rest));
    match (quarter as i32).rem_euclid(4) {
        0 => (s, c),
        1 => (c, -s),
        2 => (-s, -c),
        _ => (-c, s),
    }
}

/// A text is no view.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error(
    "`{text}` is no view: {reason}; expected front, back, left, right, top, bottom, iso or \
     AZIMUTH,ELEVATION in degrees, then `,x`, `,y` or `,z` for the axis that is up (y if none is \
     said), for example `iso,z` or `35,20`"
)]
pub struct ParseViewError {
    text: String,
    reason: &'static str,
}

impl FromStr for View {
    type Err = ParseViewError;

    fn from_str(text: &str) -> Result<Self, ParseViewError> {
        let wrong = |reason| ParseViewError { text: text.chars().take(80).collect(), reason };
        let mut parts: Vec<&str> = text.split(',').map(str::trim).collect();
        let up = match parts.last().copied() {
            Some("x" | "X") => Some(Axis::X),
            Some("y" | "Y") => Some(Axis::Y),
            Some("z" | "Z") => Some(Axis::Z),
            _ => None,
        };
        if up.is_some() {
            parts.pop();
        }
        let number =
            |s: &str| s.parse().map_err(|_| wrong("an angle is a number of degrees, not a word"));
        let (azimuth, elevation) = match parts[..] {
            ["front"] => (0.0, 0.0),
            ["right"] => (90.0, 0.0),
            ["back"] => (180.0, 0.0),
            ["left"] => (-90.0, 0.0),
            ["top"] => (0.0, 90.0),
            ["bottom"] => (0.0, -90.0),
            ["iso"] => (Self::default().azimuth, Self::default().elevation),
            [a, e] => (number(a)?, number(e)?),
            [_] => return Err(wrong("that name is not known")),
            [] => return Err(wrong("it says nothing but the axis")),
            _ => return Err(wrong("it has too many parts")),
        };
        let view = Self { azimuth, elevation, up: up.unwrap_or_default(), ..Self::default() };
        view.check().map_err(|_| {
            wrong("the azimuth must be finite and the elevation from -90 to 90 degrees")
        })?;
        Ok(view)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_axes_are_a_right_handed_frame() {
        for up in [Axis::X, Axis::Y, Axis::Z] {
            for (azimuth, elevation) in [(0., 0.), (35., 20.), (-120., -80.), (720.5, 90.)] {
                let [x, y, z] = View { azimuth, elevation, up, ..View::default() }.axes();
                assert!((x.cross(y) - z).length() < 1e-15, "{up:?} {azimuth} {elevation}");
                assert!((x.length() - 1.0).abs() < 1e-15 && x.dot(y).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn names_stand_where_they_say() {
        let towards = |text: &str| text.parse::<View>().unwrap().axes()[2];
        assert_eq!(towards("front"), Vec3::new(0., 0., 1.));
        assert_eq!(towards("right"), Vec3::new(1., 0., 0.));
        assert_eq!(towards("left"), Vec3::new(-1., 0., 0.));
        assert_eq!(towards("top"), Vec3::new(0., 1., 0.));
        assert_eq!(towards("front,z"), Vec3::new(0., -1., 0.));
        assert_eq!(towards(" top , Z "), Vec3::new(0., 0., 1.));
        assert_eq!(towards("right,z"), towards("90,0,z"));
    }

    #[test]
    fn what_is_no_view_says_what_is() {
        for text in
            ["", "z", "sideways", "1", "1,2,3", "1,2,z,z", "inf,0", "0,91", "nan,nan", "a,b"]
        {
            let message = text.parse::<View>().unwrap_err().to_string();
            assert!(message.contains("front") && message.contains("AZIMUTH"), "{message}");
        }
    }
}
