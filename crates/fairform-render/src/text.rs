//! A line of text in a picture.

use ab_glyph::{Font, FontRef, Glyph, PxScale, ScaleFont, point};

/// Characters of a title that are looked at.
const LONGEST: usize = 400;

/// Size of raised characters.
const RAISED: f32 = 0.68;

/// The character that is raised.
fn lowered(c: char) -> Option<char> {
    let raised = "⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁺";
    let at = raised.chars().position(|r| r == c)?;
    "0123456789−+".chars().nth(at)
}

/// Lays out text in Ubuntu Light.
pub(crate) struct Typeface(FontRef<'static>);

impl Typeface {
    pub(crate) fn new() -> Self {
        let font = FontRef::try_from_slice(epaint_default_fonts::UBUNTU_LIGHT);
        Self(font.expect("the font is part of the program"))
    }

    /// The glyphs of a line that starts at 0 on the baseline, and its width, in pixels.
    fn lay_out(&self, text: &str, size: f32) -> (Vec<Glyph>, f32) {
        let font = self.0.as_scaled(PxScale::from(size));
        let mut x = 0.0;
        let mut glyphs: Vec<Glyph> = Vec::new();
        for c in text.chars().take(LONGEST).filter(|c| !c.is_control()) {
            // The typeface has no raised minus, and its digits shall match.
            if let Some(c) = lowered(c) {
                let id = font.glyph_id(c);
                glyphs.push(id.with_scale_and_position(RAISED * size, point(x, -0.32 * size)));
                x += RAISED * font.h_advance(id);
                continue;
            }
            let id = font.glyph_id(c);
            if let Some(last) = glyphs.last() {
                x += font.kern(last.id, id);
            }
            glyphs.push(id.with_scale_and_position(size, point(x, 0.0)));
            x += font.h_advance(id);
        }
        (glyphs, x)
    }

    /// Width of a line in pixels.
    pub(crate) fn width(&self, text: &str, size: f32) -> f32 {
        self.lay_out(text, size).1
    }

    /// The size, at most `size`, at which a text is no wider than `room`.
    pub(crate) fn fitting(&self, text: &str, size: f32, room: f32) -> f32 {
        let (_, width) = self.lay_out(text, size);
        if width > room { size * room / width } else { size }
    }

    /// Calls `paint` with column, row and coverage for every pixel of a line centred at `x` with its
    /// baseline at `y`; also pixels outside the picture.
    pub(crate) fn draw(
        &self,
        text: &str,
        size: f32,
        [x, y]: [f32; 2],
        mut paint: impl FnMut(i64, i64, f32),
    ) {
        let (glyphs, width) = self.lay_out(text, size);
        // On whole pixels, where letters are sharpest.
        let (left, base) = ((x - 0.5 * width).round(), y.round());
        for mut glyph in glyphs {
            glyph.position = point(glyph.position.x + left, glyph.position.y + base);
            let Some(outline) = self.0.outline_glyph(glyph) else { continue };
            let corner = outline.px_bounds().min;
            outline.draw(|i, j, coverage| {
                paint(corner.x as i64 + i64::from(i), corner.y as i64 + i64::from(j), coverage);
            });
        }
    }
}
