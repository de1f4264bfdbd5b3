//! [`ColourMap`]: numbers as colours.

use std::fmt;
use std::str::FromStr;

use crate::Colour;

/// Colours for the numbers from 0 to 1.
///
/// ```
/// use fairform_render::{Colour, ColourMap};
/// assert_eq!("coolwarm".parse(), Ok(ColourMap::CoolWarm));
/// assert_eq!(ColourMap::Viridis.at(-3.0), ColourMap::Viridis.at(0.0));
/// assert_eq!(ColourMap::Viridis.at(f64::NAN), Colour::MISSING);
/// ```
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum ColourMap {
    /// From dark violet over green to yellow, in even steps to the eye, also to one that sees few
    /// colours: for sizes and distances. By van der Walt, Smith and Firing, in the public domain.
    #[default]
    Viridis,
    /// From blue over white to red, as light on one side as on the other: for what has a sign.
    /// \[Moreland2009\]
    CoolWarm,
    /// Around the circle of hues, all equally light, where 1 is 0 again: for angles. Numbers outside
    /// go around. \[Ottosson2020\]
    Cyclic,
}

impl ColourMap {
    /// All maps.
    pub const ALL: [Self; 3] = [Self::Viridis, Self::CoolWarm, Self::Cyclic];

    /// The name that it is read from.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Viridis => "viridis",
            Self::CoolWarm => "coolwarm",
            Self::Cyclic => "cyclic",
        }
    }

    /// Whether the middle means "nothing" and the ends are opposite.
    #[must_use]
    pub fn is_diverging(self) -> bool {
        self == Self::CoolWarm
    }

    /// The colour of `t` from 0 to 1. What is outside has the colour of the end, or goes around if
    /// the map does; NaN is [`Colour::MISSING`].
    #[must_use]
    pub fn at(self, t: f64) -> Colour {
        if t.is_nan() {
            return Colour::MISSING;
        }
        let inside = t.clamp(0.0, 1.0);
        match self {
            Self::Viridis => viridis(inside),
            Self::CoolWarm => cool_warm(inside),
            Self::Cyclic if t.is_finite() => cyclic(t - libm::floor(t)),
            Self::Cyclic => cyclic(inside),
        }
    }
}

impl fmt::Display for ColourMap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// A text names no map of colours.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error("`{0}` is no map of colours: expected viridis, coolwarm or cyclic")]
pub struct ParseColourMapError(String);

impl FromStr for ColourMap {
    type Err = ParseColourMapError;

    fn from_str(text: &str) -> Result<Self, ParseColourMapError> {
        let wrong = || ParseColourMapError(text.chars().take(80).collect());
        Self::ALL.into_iter().find(|map| map.name() == text).ok_or_else(wrong)
    }
}

/// Every fifteenth of the 256 published colours (CC0), which the lines between them meet to within
/// half a byte.
const VIRIDIS: [[f64; 3]; 18] = [
    [0.267_004, 0.004_874, 0.329_415],
    [0.281_924, 0.089_666, 0.412_415],
    [0.280_255, 0.165_693, 0.476_498],
    [0.263_663, 0.237_631, 0.518_762],
    [0.237_441, 0.305_202, 0.541_921],
    [0.208_623, 0.367_752, 0.552_675],
    [0.182_256, 0.426_184, 0.557_120],
    [0.159_194, 0.482_237, 0.558_073],
    [0.137_770, 0.537_492, 0.554_906],
    [0.121_148, 0.592_739, 0.544_641],
    [0.128_087, 0.647_749, 0.523_491],
    [0.180_653, 0.701_402, 0.488_189],
    [0.274_149, 0.751_988, 0.436_601],
    [0.395_174, 0.797_475, 0.367_757],
    [0.535_621, 0.835_785, 0.281_908],
    [0.688_944, 0.865_448, 0.182_725],
    [0.845_561, 0.887_322, 0.099_702],
    [0.993_248, 0.906_157, 0.143_936],
];

#[expect(clippy::cast_sign_loss, reason = "t is from 0 to 1")]
fn viridis(t: f64) -> Colour {
    let at = t * (VIRIDIS.len() - 1) as f64;
    let i = (at as usize).min(VIRIDIS.len() - 2);
    let (a, b, s) = (VIRIDIS[i], VIRIDIS[i + 1], at - i as f64);
    let [r, g, b] = [0, 1, 2].map(|k| a[k] + s * (b[k] - a[k]));
    Colour { r, g, b, a: 1.0 }
}

/// Between two colours of the same magnitude $`M`$ and saturation $`s`$ over a white of magnitude 88,
/// straight in $`M`$, $`s`$ and hue $`h`$, where
/// $`L = M \cos s`$, $`a = M \sin s \cos h`$, $`b = M \sin s \sin h`$. Hues turn towards the white by
/// $`s \sqrt{88^2 - M^2} / (M \sin s)`$, so that the colours there keep their steps. \[Moreland2009\]
fn cool_warm(t: f64) -> Colour {
    const MAGNITUDE: f64 = 80.0;
    const SATURATION: f64 = 1.08;
    const WHITE: f64 = 88.0;
    const BLUE: f64 = -1.1;
    const RED: f64 = 0.5;
    let spin = SATURATION * (WHITE * WHITE - MAGNITUDE * MAGNITUDE).sqrt()
        / (MAGNITUDE * libm::sin(SATURATION));
    // 0 in the middle, 1 at the ends.
    let away = (2.0 * t - 1.0).abs();
    let (end, turned) = if t < 0.5 { (BLUE, BLUE - spin) } else { (RED, RED + spin) };
    let magnitude = WHITE + away * (MAGNITUDE - WHITE);
    let saturation = away * SATURATION;
    let hue = turned + away * (end - turned);
    let (l, chroma) = (magnitude * libm::cos(saturation), magnitude * libm::sin(saturation));
    from_lab(l, chroma * libm::cos(hue), chroma * libm::sin(hue))
}

/// From CIELAB under the white D65.
fn from_lab(l: f64, a: f64, b: f64) -> Colour {
    let y = (l + 16.0) / 116.0;
    let cube = |f: f64| {
        if f > 6.0 / 29.0 { f * f * f } else { 3.0 * 36.0 / 841.0 * (f - 4.0 / 29.0) }
    };
    let (x, y, z) = (0.950_47 * cube(y + a / 500.0), cube(y), 1.088_83 * cube(y - b / 200.0));
    from_light([
        3.240_454_2 * x - 1.537_138_5 * y - 0.498_531_4 * z,
        -0.969_266 * x + 1.876_010_8 * y + 0.041_556 * z,
        0.055_643_4 * x - 0.204_025_9 * y + 1.057_225_2 * z,
    ])
}

/// The circle of lightness and chroma in Oklab that has the strongest colours that all exist.
fn cyclic(t: f64) -> Colour {
    const LIGHTNESS: f64 = 0.74;
    const CHROMA: f64 = 0.12;
    let hue = std::f64::consts::TAU * t;
    let (a, b) = (CHROMA * libm::cos(hue), CHROMA * libm::sin(hue));
    let cube = |x: f64| x * x * x;
    let l = cube(LIGHTNESS + 0.396_337_777_4 * a + 0.215_803_757_3 * b);
    let m = cube(LIGHTNESS - 0.105_561_345_8 * a - 0.063_854_172_8 * b);
    let s = cube(LIGHTNESS - 0.089_484_177_5 * a - 1.291_485_548_0 * b);
    from_light([
        4.076_741_662_1 * l - 3.307_711_591_3 * m + 0.230_969_929_2 * s,
        -1.268_438_004_6 * l + 2.609_757_401_1 * m - 0.341_319_396_5 * s,
        -0.004_196_086_3 * l - 0.703_418_614_7 * m + 1.707_614_701_0 * s,
    ])
}

fn from_light(light: [f64; 3]) -> Colour {
    let [r, g, b] = light.map(crate::colour::component);
    Colour { r, g, b, a: 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn luminance(c: Colour) -> f64 {
        let [r, g, b, _] = c.linear().map(f64::from);
        0.2126 * r + 0.7152 * g + 0.0722 * b
    }

    /// CIE lightness from 0 to 100.
    fn lightness(c: Colour) -> f64 {
        116.0 * luminance(c).cbrt() - 16.0
    }

    #[test]
    fn the_sequential_map_gets_lighter_in_even_steps() {
        let all: Vec<f64> =
            (0..=100).map(|i| lightness(ColourMap::Viridis.at(f64::from(i) / 100.0))).collect();
        let step = (all[100] - all[0]) / 100.0;
        assert!(step > 0.7, "{step}");
        for pair in all.windows(2) {
            let rise = pair[1] - pair[0];
            assert!(rise > 0.6 * step && rise < 1.4 * step, "{rise} of {step}");
        }
    }

    /// The numbers in the paper: its ends, and the grey white in the middle.
    #[test]
    fn the_diverging_map_is_the_published_one() {
        for (t, expected) in [(0.0, 0x3b_4c_c0), (0.5, 0xdd_dd_dd), (1.0, 0xb4_04_26)] {
            let (is, should) = (ColourMap::CoolWarm.at(t), Colour::hex(expected));
            for (a, b) in [(is.r, should.r), (is.g, should.g), (is.b, should.b)] {
                assert!((a - b).abs() < 1.6 / 255.0, "{is} at {t}");
            }
        }
    }

    #[test]
    fn both_sides_of_the_diverging_map_are_equally_light() {
        for i in 0..=50 {
            let t = f64::from(i) / 100.0;
            let [a, b] = [t, 1.0 - t].map(|t| lightness(ColourMap::CoolWarm.at(t)));
            assert!((a - b).abs() < 0.3, "{a} {b} at {t}");
            let [a, b] = [t, 1.0 - t].map(|t| ColourMap::CoolWarm.at(t));
            assert!(i == 50 || a.b > a.r && b.r > b.b, "{a} {b} at {t}");
        }
    }

    #[test]
    fn the_cyclic_map_is_closed_and_in_range() {
        assert_eq!(ColourMap::Cyclic.at(0.0), ColourMap::Cyclic.at(1.0));
        assert_eq!(ColourMap::Cyclic.at(-0.25), ColourMap::Cyclic.at(0.75));
        for i in 0..360 {
            let c = ColourMap::Cyclic.at(f64::from(i) / 360.0);
            for x in [c.r, c.g, c.b] {
                assert!(x > 0.01 && x < 0.99, "{c} at {i}");
            }
            assert!((lightness(c) - 70.0).abs() < 4.0, "{} at {i}", lightness(c));
        }
    }

    #[test]
    fn what_is_no_number_is_grey_and_what_is_outside_is_at_the_end() {
        for map in ColourMap::ALL {
            assert_eq!(map.at(f64::NAN), Colour::MISSING);
            assert_eq!(map.at(f64::INFINITY), map.at(1.0));
            assert_eq!(map.at(f64::NEG_INFINITY), map.at(0.0));
            assert_eq!(map.name().parse(), Ok(map));
        }
        let message = "jet".parse::<ColourMap>().unwrap_err().to_string();
        assert!(ColourMap::ALL.iter().all(|m| message.contains(m.name())), "{message}");
    }
}
