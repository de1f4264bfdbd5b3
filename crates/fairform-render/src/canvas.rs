//! [`Canvas`]: the pixels of a picture, and ink on them.

use crate::Colour;
use crate::layout::Rectangle;

/// The pixels of a picture.
pub(crate) struct Canvas {
    width: usize,
    pub(crate) pixels: Vec<[u8; 4]>,
}

/// A colour to draw with, in bytes that may have fractions, and its opacity.
#[derive(Clone, Copy)]
pub(crate) struct Ink {
    colour: [f32; 3],
    opacity: f32,
}

impl Ink {
    pub(crate) fn new(colour: Colour) -> Self {
        let Colour { r, g, b, a } = colour;
        Self { colour: [r, g, b].map(|c| 255.0 * c as f32), opacity: a as f32 }
    }

    /// What can be read on a background.
    pub(crate) fn on(background: Colour) -> Self {
        let Colour { r, g, b, a } = background;
        let is_dark = a > 0.5 && 0.3 * r + 0.6 * g + 0.1 * b < 0.45;
        Self::new(if is_dark { Colour::hex(0xf0_f2_f5) } else { Colour::INK })
    }

    /// The same, less opaque.
    pub(crate) fn faded(self, by: f32) -> Self {
        Self { opacity: by * self.opacity, ..self }
    }
}

impl Canvas {
    pub(crate) fn new((width, height): (u32, u32), background: Colour) -> Self {
        let [r, g, b, a] = background.linear();
        #[expect(clippy::cast_sign_loss, reason = "clamped to 0..1")]
        let opacity = (a * 255.0).round() as u8;
        let empty = [r, g, b].map(crate::colour::encode);
        let pixel = if opacity == 0 { [0; 4] } else { [empty[0], empty[1], empty[2], opacity] };
        let (width, height) = (width as usize, height as usize);
        Self { width, pixels: vec![pixel; width * height] }
    }

    /// Copies rows of `width` pixels to where the first is at the column `left` and the row `top`.
    pub(crate) fn put(&mut self, [left, top]: [usize; 2], width: usize, pixels: &[[u8; 4]]) {
        for (y, row) in pixels.chunks_exact(width).enumerate() {
            let at = (top + y) * self.width + left;
            self.pixels[at..at + width].copy_from_slice(row);
        }
    }

    /// Ink on a part of a pixel, if there is such a pixel.
    pub(crate) fn ink(&mut self, x: i64, y: i64, ink: &Ink, coverage: f32) {
        let (Ok(x), Ok(y)) = (usize::try_from(x), usize::try_from(y)) else { return };
        if x < self.width
            && let Some(pixel) = self.pixels.get_mut(y.saturating_mul(self.width) + x)
        {
            *pixel = inked(*pixel, ink.colour, ink.opacity * coverage);
        }
    }

    /// Fills a rectangle, whose sides need not be on whole pixels.
    pub(crate) fn fill(&mut self, [left, top, width, height]: Rectangle, ink: &Ink) {
        let (right, bottom) = (left + width, top + height);
        let part = |i: i64, low: f32, high: f32| ((i + 1) as f32).min(high) - (i as f32).max(low);
        for y in top.floor() as i64..bottom.ceil() as i64 {
            for x in left.floor() as i64..right.ceil() as i64 {
                let coverage = part(x, left, right).max(0.0) * part(y, top, bottom).max(0.0);
                self.ink(x, y, ink, coverage);
            }
        }
    }

    /// Fills a triangle.
    pub(crate) fn triangle(&mut self, corners: [[f32; 2]; 3], ink: &Ink) {
        const STEPS: u8 = 8;
        let [a, b, c] = corners;
        let range = |k: usize| {
            let (low, high) = (a[k].min(b[k]).min(c[k]), a[k].max(b[k]).max(c[k]));
            low.floor() as i64..high.ceil() as i64
        };
        let turn = |p: [f32; 2], q: [f32; 2], r: [f32; 2]| {
            (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
        };
        let side = turn(a, b, c).signum();
        for y in range(1) {
            for x in range(0) {
                let inside = (0..STEPS * STEPS).filter(|&i| {
                    let [u, v] = [i % STEPS, i / STEPS].map(|k| (f32::from(k) + 0.5) / 8.0);
                    let p = [x as f32 + u, y as f32 + v];
                    [(a, b), (b, c), (c, a)].iter().all(|&(q, r)| side * turn(q, r, p) >= 0.0)
                });
                let coverage = inside.count() as f32 / f32::from(STEPS * STEPS);
                self.ink(x, y, ink, coverage);
            }
        }
    }
}

/// Ink over a pixel. Mixed as bytes, not as light: thin dark letters look lighter than they are.
fn inked(pixel: [u8; 4], ink: [f32; 3], coverage: f32) -> [u8; 4] {
    let coverage = coverage.clamp(0.0, 1.0);
    let below = f32::from(pixel[3]) / 255.0;
    let opacity = coverage + (1.0 - coverage) * below;
    if opacity <= 0.0 {
        return pixel;
    }
    let share = coverage / opacity;
    #[expect(clippy::cast_sign_loss, reason = "between two bytes")]
    let mix = |from: f32, to: f32| (from + share * (to - from)).round() as u8;
    let [r, g, b] = std::array::from_fn(|k| mix(f32::from(pixel[k]), ink[k]));
    #[expect(clippy::cast_sign_loss, reason = "from 0 to 1")]
    let opacity = (opacity * 255.0).round() as u8;
    [r, g, b, opacity]
}
