//! Colour bars with their numbers.

use crate::Colour;
use crate::canvas::{Canvas, Ink};
use crate::layout::Rectangle;
use crate::text::Typeface;
use crate::values::Gauge;

/// Height of a bar below a panel with all that is at it, in heights of its text.
pub(crate) const HEIGHT_BELOW: f32 = 4.0;

/// Parts of a bar, in heights of its text.
const BAR: f32 = 0.8;
const TICK: f32 = 0.22;
const GAP: f32 = 0.35;

/// A bar on its way into a picture.
pub(crate) struct Pen<'a> {
    pub(crate) canvas: &'a mut Canvas,
    pub(crate) typeface: &'a Typeface,
    pub(crate) ink: Ink,
    /// Height of the text in pixels.
    pub(crate) size: f32,
}

/// The numbers at a bar and where they are, from 0 to 1.
fn labels(gauge: &Gauge) -> Vec<(f32, String)> {
    let labelled = gauge.ticks().filter_map(|t| Some((gauge.place(t), t.label.as_ref()?.text())));
    labelled.collect()
}

/// Width of an upright bar with all that is at it and the space around it.
pub(crate) fn width_aside(gauge: &Gauge, typeface: &Typeface, size: f32) -> f32 {
    let numbers =
        labels(gauge).iter().map(|(_, text)| typeface.width(text, size)).fold(0.0, f32::max);
    let none = if gauge.missing { typeface.width(NONE, size) } else { 0.0 };
    numbers.max(none) + (BAR + TICK + 2.0 * GAP + 1.15 + 1.6) * size
}

/// Places of a pixel at which a bar is looked at.
const PARTS: u8 = 8;

/// What is said of the colour of what has no value.
const NONE: &str = "none";

/// Where a bar goes, and which way.
struct Bar {
    /// The end of the first colour, at the upper or left side of the bar.
    start: [f32; 2],
    length: f32,
    thickness: f32,
    upright: bool,
}

impl Bar {
    /// A place so far along the bar, and so far across it towards its numbers, in pixels.
    fn at(&self, along: f32, across: f32) -> [f32; 2] {
        let [x, y] = self.start;
        if self.upright { [x + across, y - along] } else { [x + along, y + across] }
    }

    /// The rectangle between two such places.
    fn rectangle(&self, along: [f32; 2], across: [f32; 2]) -> Rectangle {
        let ([a, b], [c, d]) = (self.at(along[0], across[0]), self.at(along[1], across[1]));
        [a.min(c), b.min(d), (a - c).abs(), (b - d).abs()]
    }
}

impl Pen<'_> {
    /// An upright bar in the middle of a rectangle, with its numbers and its title at the right.
    pub(crate) fn upright(&mut self, gauge: &Gauge, [left, top, _, height]: Rectangle) {
        let size = self.size;
        let tail = if gauge.missing { 1.9 * size } else { 0.0 };
        let length = (0.62 * height).min(19.0 * size).min(height - tail - 3.0 * size);
        if length < 2.0 * size {
            return;
        }
        let (x, y) = ((left + 0.5 * size).round(), (top + 0.5 * (height - length - tail)).round());
        let bar = Bar {
            start: [x, y + length.round()],
            length: length.round(),
            thickness: (BAR * size).round().max(1.0),
            upright: true,
        };
        self.bar(gauge, &bar);
        let mut widest = 0.0_f32;
        let numbers = bar.thickness + (TICK + GAP) * size;
        for (share, text) in labels(gauge) {
            let [x, y] = bar.at(share * bar.length, numbers);
            let width = self.typeface.width(&text, size);
            widest = widest.max(width);
            self.write(&text, size, [x + 0.5 * width, y + 0.3 * size]);
        }
        if gauge.missing {
            let low = -1.1 * size - bar.thickness;
            self.swatch(bar.rectangle([low, low + bar.thickness], [0.0, bar.thickness]));
            let [x, y] = bar.at(low + 0.5 * bar.thickness, numbers);
            let width = self.typeface.width(NONE, size);
            widest = widest.max(width);
            self.write(NONE, size, [x + 0.5 * width, y + 0.3 * size]);
        }
        let [x, y] = bar.at(0.5 * bar.length, numbers + widest + GAP * size + 0.85 * size);
        let title = gauge.legend.as_deref().unwrap_or_default();
        let size = self.typeface.fitting(title, size, 0.96 * height);
        let middle = y.clamp(top, top + height);
        let Self { canvas, typeface, ink, .. } = self;
        typeface.draw(title, size, [0.0, 0.0], |i, j, coverage| {
            canvas.ink(x.round() as i64 + j, middle.round() as i64 - i, ink, coverage);
        });
    }

    /// A lying bar in the middle of the upper side of a rectangle, with numbers and title below.
    pub(crate) fn lying(&mut self, gauge: &Gauge, [left, top, width, _]: Rectangle) {
        let size = self.size;
        let tail = if gauge.missing { 3.2 * size } else { 0.0 };
        let length = (0.74 * width - tail).min(17.0 * size).round();
        if length < 2.0 * size {
            return;
        }
        let start = [left + 0.5 * (width - length - tail), top + 0.35 * size].map(f32::round);
        let thickness = (BAR * size).round().max(1.0);
        let bar = Bar { start, length, thickness, upright: false };
        self.bar(gauge, &bar);
        let numbers = bar.thickness + TICK * size + 0.95 * size;
        // Every second number, or fewer, where all do not find room.
        let all = labels(gauge);
        let widths: Vec<f32> = all.iter().map(|(_, t)| self.typeface.width(t, size)).collect();
        let zero = all.iter().position(|(_, text)| text == "0").unwrap_or(0);
        let shown = |every: usize| (0..all.len()).filter(move |i| i % every == zero % every);
        let fits = |every: &usize| {
            let ends = |i: usize| {
                let middle = all[i].0 * length;
                [middle - 0.5 * widths[i], middle + 0.5 * widths[i]]
            };
            shown(*every)
                .zip(shown(*every).skip(1))
                .all(|(a, b)| ends(a)[1] + 0.6 * size < ends(b)[0])
        };
        let every = (1..=all.len().max(1)).find(fits).unwrap_or(1);
        for i in shown(every) {
            self.write(&all[i].1, size, bar.at(all[i].0 * length, numbers));
        }
        if gauge.missing {
            let right = length + 1.6 * size;
            self.swatch(bar.rectangle([right, right + bar.thickness], [0.0, bar.thickness]));
            self.write(NONE, size, bar.at(right + 0.5 * bar.thickness, numbers));
        }
        let title = gauge.legend.as_deref().unwrap_or_default();
        let title_size = self.typeface.fitting(title, size, 0.94 * width);
        self.write(title, title_size, [left + 0.5 * width, start[1] + numbers + 1.2 * size]);
    }

    /// The colours, what is beyond them as a point at the end, a frame, and the ticks.
    fn bar(&mut self, gauge: &Gauge, bar: &Bar) {
        let line = (0.06 * self.size).max(1.0).round();
        let colour = |t: f32| {
            let bands = gauge.bands.map(|n| n as f32);
            let t = bands.map_or(t, |n| ((t * n).floor().clamp(0.0, n - 1.0) + 0.5) / n);
            gauge.map.at(f64::from(t))
        };
        // The borders of bands need not be on whole pixels, as the ends are.
        for i in 0..bar.length as u16 {
            let parts = (0..PARTS).map(|k| {
                let at = f32::from(i) + (f32::from(k) + 0.5) / f32::from(PARTS);
                colour(at / bar.length)
            });
            let [r, g, b] = parts.fold([0.0; 3], |[r, g, b], c| [r + c.r, g + c.g, b + c.b]);
            let mean = [r, g, b, f64::from(PARTS)].map(|sum| sum / f64::from(PARTS));
            let along = [f32::from(i), f32::from(i) + 1.0];
            let across = [0.0, bar.thickness];
            self.canvas.fill(bar.rectangle(along, across), &Ink::new(mean.into()));
        }
        let frame = self.ink.faded(0.75);
        let point = 0.75 * bar.thickness;
        for (is_there, end, t) in [(gauge.below, 0.0, 0.0), (gauge.above, bar.length, 1.0)] {
            let out = if t == 0.0 { -1.0 } else { 1.0 };
            if !is_there {
                let along = if t == 0.0 { [-line, 0.0] } else { [end, end + line] };
                self.canvas.fill(bar.rectangle(along, [-line, bar.thickness + line]), &frame);
                continue;
            }
            let tip = |thickness: f32, over: f32, reach: f32| {
                [
                    bar.at(end, -over),
                    bar.at(end, thickness + over),
                    bar.at(end + out * reach, 0.5 * thickness),
                ]
            };
            self.canvas.triangle(tip(bar.thickness, line, point + 1.6 * line), &frame);
            self.canvas.triangle(tip(bar.thickness, 0.0, point), &Ink::new(colour(t)));
        }
        for across in [[-line, 0.0], [bar.thickness, bar.thickness + line]] {
            self.canvas.fill(bar.rectangle([0.0, bar.length], across), &frame);
        }
        for tick in gauge.ticks() {
            let is_long = tick.label.is_some();
            let middle = (gauge.place(tick) * bar.length - 0.5 * line)
                .round()
                .clamp(0.0, (bar.length - line).max(0.0));
            let length = if is_long { TICK } else { 0.5 * TICK } * self.size;
            let ink = if is_long { self.ink } else { frame };
            let across = [bar.thickness + line, bar.thickness + line + length];
            self.canvas.fill(bar.rectangle([middle, middle + line], across), &ink);
        }
    }

    /// The colour of what has no value.
    fn swatch(&mut self, [left, top, width, height]: Rectangle) {
        let line = (0.06 * self.size).max(1.0).round();
        let around = [left - line, top - line, width + 2.0 * line, height + 2.0 * line];
        self.canvas.fill(around, &self.ink.faded(0.75));
        self.canvas.fill([left, top, width, height], &Ink::new(Colour::MISSING));
    }

    /// A line centred at a place of its base line.
    pub(crate) fn write(&mut self, text: &str, size: f32, place: [f32; 2]) {
        let Self { canvas, typeface, ink, .. } = self;
        typeface.draw(text, size, place, |x, y, coverage| canvas.ink(x, y, ink, coverage));
    }
}
