//! [`Colour`], and light as numbers that can be added.

use std::fmt;
use std::str::FromStr;
use std::sync::LazyLock;

/// A colour in sRGB, the components from 0 to 1, with straight (not premultiplied) opacity.
///
/// Numbers outside are clamped and NaN counts as 0 when the colour is used.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Colour {
    /// Red.
    pub r: f64,
    /// Green.
    pub g: f64,
    /// Blue.
    pub b: f64,
    /// Opacity: 0 is invisible, 1 hides what is behind.
    pub a: f64,
}

impl Colour {
    /// White.
    pub const WHITE: Self = Self::hex(0xff_ff_ff);
    /// Black.
    pub const BLACK: Self = Self::hex(0);
    /// Nothing at all: black of opacity 0.
    pub const TRANSPARENT: Self = Self::BLACK.with_opacity(0.0);
    /// The quiet blue of a surface that nobody gave a colour.
    pub const PORCELAIN: Self = Self::hex(0xa9_c1_dc);
    /// The muted clay of a surface seen from behind.
    pub const CLAY: Self = Self::hex(0xcf_a9_86);
    /// A dark blue grey for edges.
    pub const INK: Self = Self::hex(0x1d_26_33);
    /// The grey of what has no value.
    pub const MISSING: Self = Self::hex(0x9a_9a_9a);
    /// A strong red for boundaries.
    pub const RED: Self = Self::hex(0xd6_2a_2a);

    /// An opaque colour from 0xRRGGBB.
    #[must_use]
    pub const fn hex(rgb: u32) -> Self {
        let [_, r, g, b] = rgb.to_be_bytes();
        Self { r: r as f64 / 255.0, g: g as f64 / 255.0, b: b as f64 / 255.0, a: 1.0 }
    }

    /// The same colour with another opacity.
    #[must_use]
    pub const fn with_opacity(self, a: f64) -> Self {
        Self { a, ..self }
    }

    /// Linear light and opacity.
    pub(crate) fn linear(self) -> [f32; 4] {
        [decode(self.r), decode(self.g), decode(self.b), clamp(self.a) as f32]
    }
}

impl From<[f64; 4]> for Colour {
    fn from([r, g, b, a]: [f64; 4]) -> Self {
        Self { r, g, b, a }
    }
}

/// A text is no colour.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error(
    "`{0}` is no colour: expected #rgb, #rrggbb, #rrggbbaa, or one of white, black, grey, red, \
     orange, yellow, green, blue, purple, porcelain, clay, ink, transparent"
)]
pub struct ParseColourError(String);

impl FromStr for Colour {
    type Err = ParseColourError;

    /// Reads `#rgb`, `#rrggbb`, `#rrggbbaa` or a name such as `red` or `porcelain`.
    fn from_str(text: &str) -> Result<Self, ParseColourError> {
        let wrong = || ParseColourError(text.chars().take(80).collect());
        if let Some(digits) = text.strip_prefix('#') {
            if !digits.bytes().all(|b| b.is_ascii_hexdigit()) {
                return Err(wrong());
            }
            let number = |s: &str| u32::from_str_radix(s, 16).map_err(|_| wrong());
            return match digits.len() {
                3 => number(digits).map(|n| {
                    Self::hex((n & 0xf00) * 0x1100 + (n & 0xf0) * 0x110 + (n & 0xf) * 0x11)
                }),
                6 => number(digits).map(Self::hex),
                8 => number(digits)
                    .map(|n| Self::hex(n >> 8).with_opacity(f64::from(n & 0xff) / 255.0)),
                _ => Err(wrong()),
            };
        }
        Ok(match text {
            "white" => Self::WHITE,
            "black" => Self::BLACK,
            "grey" | "gray" => Self::hex(0x9a_9f_a6),
            "red" => Self::RED,
            "orange" => Self::hex(0xe6_8a_2e),
            "yellow" => Self::hex(0xf0_d0_60),
            "green" => Self::hex(0x5f_a8_6a),
            "blue" => Self::hex(0x3f_77_b8),
            "purple" => Self::hex(0x85_6a_b0),
            "porcelain" => Self::PORCELAIN,
            "clay" => Self::CLAY,
            "ink" => Self::INK,
            "transparent" => Self::TRANSPARENT,
            _ => return Err(wrong()),
        })
    }
}

impl fmt::Display for Colour {
    /// Writes `#rrggbb`, or `#rrggbbaa` when not opaque.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [r, g, b, a] = [self.r, self.g, self.b, self.a].map(byte);
        write!(f, "#{r:02x}{g:02x}{b:02x}")?;
        if a < 255 { write!(f, "{a:02x}") } else { Ok(()) }
    }
}

fn clamp(x: f64) -> f64 {
    // NaN fails the comparison.
    if x > 0.0 { x.min(1.0) } else { 0.0 }
}

#[expect(clippy::cast_sign_loss, reason = "clamped to 0..1")]
fn byte(x: f64) -> u8 {
    (clamp(x) * 255.0).round() as u8
}

/// Light of an sRGB component. \[IEC 61966-2-1\]
fn decode(c: f64) -> f32 {
    let c = clamp(c);
    (if c <= 0.04045 { c / 12.92 } else { libm::pow((c + 0.055) / 1.055, 2.4) }) as f32
}

/// sRGB component of light. \[IEC 61966-2-1\]
pub(crate) fn component(light: f64) -> f64 {
    let l = clamp(light);
    if l <= 0.003_130_8 { 12.92 * l } else { 1.055 * libm::pow(l, 1.0 / 2.4) - 0.055 }
}

/// sRGB component of light, as a byte. Finer steps than a byte has even in the dark, so that every
/// byte comes back from its own light.
pub(crate) fn encode(light: f32) -> u8 {
    const STEPS: usize = 4096;
    static TABLE: LazyLock<Vec<u8>> =
        LazyLock::new(|| (0..=STEPS).map(|i| byte(component(i as f64 / STEPS as f64))).collect());
    #[expect(clippy::cast_sign_loss, reason = "a cast from negative or NaN light gives 0")]
    let i = (light * STEPS as f32 + 0.5) as usize;
    TABLE[i.min(STEPS)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_byte_survives_the_way_through_light() {
        for i in 0..=255_u8 {
            assert_eq!(encode(decode(f64::from(i) / 255.0)), i);
        }
        assert_eq!(encode(f32::NAN), 0);
        assert_eq!(encode(-1.0), 0);
        assert_eq!(encode(f32::INFINITY), 255);
    }

    #[test]
    fn colours_are_read_as_they_are_written() {
        for text in ["#a9c1dc", "#00000000", "#12345678", "#ffffff"] {
            assert_eq!(text.parse::<Colour>().unwrap().to_string(), text);
        }
        assert_eq!("#f0a".parse::<Colour>().unwrap(), Colour::hex(0xff_00_aa));
        for text in ["", "#", "#12", "#ggg", "#+12", "#12345é", "mauve"] {
            assert!(text.parse::<Colour>().is_err(), "{text}");
        }
    }
}
