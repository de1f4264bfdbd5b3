//! [`Paint`]: the colour of every place of a surface that has values.

use crate::scene::Vec3f;
use crate::values::Gauge;
use crate::{Colour, ColourMap, Line, Per, Values};

/// Colours by value, in linear light.
pub(crate) struct Paint {
    pub(crate) per: Per,
    /// Evenly from 0 to 1.
    palette: Vec<Vec3f>,
    missing: Vec3f,
    bands: Option<f32>,
    pub(crate) is_cyclic: bool,
    isolines: Option<Isolines>,
}

/// Lines of equal value.
struct Isolines {
    /// In order.
    levels: Vec<f32>,
    colour: [f32; 4],
    /// Half the width in pixels.
    reach: f32,
}

impl Paint {
    const STEPS: u16 = 512;

    /// `unit` is a thousandth of the shorter side of the panel in pixels.
    pub(crate) fn new(values: &Values, gauge: &Gauge, unit: f64) -> Self {
        let light = |colour: Colour| {
            let [r, g, b, _] = colour.linear();
            [r, g, b]
        };
        let at = |i: u16| light(gauge.map.at(f64::from(i) / f64::from(Self::STEPS)));
        let lines = values.isolines.filter(|l| l.width > 0.0 && values.per == Per::Vertex);
        Self {
            per: values.per,
            palette: (0..=Self::STEPS).map(at).collect(),
            missing: light(Colour::MISSING),
            bands: gauge.bands.map(|n| n as f32),
            is_cyclic: gauge.map == ColourMap::Cyclic,
            isolines: lines.map(|line: Line| Isolines {
                levels: gauge.levels(),
                colour: line.colour.linear(),
                reach: (0.5 * line.width * unit) as f32,
            }),
        }
    }

    pub(crate) fn has_isolines(&self) -> bool {
        self.isolines.is_some()
    }

    /// The colour of a value, which changes by `slope` from one pixel to the next.
    #[expect(clippy::cast_sign_loss, reason = "t is from 0 to 1")]
    pub(crate) fn colour(&self, value: f32, slope: f32) -> Vec3f {
        if value.is_nan() {
            return self.missing;
        }
        let value = if self.is_cyclic { value - value.floor() } else { value };
        let inside = value.clamp(0.0, 1.0);
        let t = self.bands.map_or(inside, |n| ((inside * n).floor().min(n - 1.0) + 0.5) / n);
        let at = t * f32::from(Self::STEPS);
        let i = (at as usize).min(self.palette.len() - 2);
        let (a, b, s) = (self.palette[i], self.palette[i + 1], at - i as f32);
        let colour: Vec3f = std::array::from_fn(|k| a[k] + s * (b[k] - a[k]));
        let Some(lines) = &self.isolines else { return colour };
        let next = lines.levels.partition_point(|&level| level < value);
        let around =
            [next.checked_sub(1).map(|i| lines.levels[i]), lines.levels.get(next).copied()];
        let is_near = around.into_iter().flatten().any(|l| (l - value).abs() < lines.reach * slope);
        let [r, g, b, opacity] = lines.colour;
        let share = if is_near { opacity } else { 0.0 };
        let line = [r, g, b];
        std::array::from_fn(|k| colour[k] + share * (line[k] - colour[k]))
    }
}
