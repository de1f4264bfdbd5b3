//! [`Values`]: numbers that a surface is coloured by; and [`Gauge`], what each number looks like.

use std::str::FromStr;

use crate::ticks::{Scale, Tick, round_step};
use crate::{ColourMap, Line, Panel, RenderError};

/// Numbers that a surface is coloured by: curvature, error, tension.
///
/// ```
/// use fairform_render::{ColourMap, Values};
/// let curvature = [0.1, -0.2, 0.05];
/// let values = Values {
///     map: ColourMap::CoolWarm,
///     legend: Some("mean curvature (1/mm)"),
///     ..Values::per_vertex(&curvature)
/// };
/// ```
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Values<'a> {
    /// The numbers. One that is NaN, or negative on a logarithmic scale, makes the faces at it grey;
    /// one beyond the range has the colour of its end.
    pub of: &'a [f64],
    /// What there is one for.
    pub per: Per,
    /// The colours.
    pub map: ColourMap,
    /// Which numbers have the first and the last colour.
    pub range: Range,
    /// Whether equal ratios, not equal differences, are equally far apart in colour.
    pub log: bool,
    /// Cuts the colours into bands, 1 to 256. An automatic range grows a little, and there are about
    /// so many bands, so that their borders are round numbers.
    pub bands: Option<u32>,
    /// Lines where the value is that of the border of a band or, without bands, of a number beside
    /// the colour bar. Needs one value per vertex.
    pub isolines: Option<Line>,
    /// What the numbers are, and their unit, written at a colour bar; without it there is no bar.
    pub legend: Option<&'a str>,
}

impl<'a> Values<'a> {
    /// One number per vertex, blended over the faces.
    #[must_use]
    pub fn per_vertex(of: &'a [f64]) -> Self {
        Self {
            of,
            per: Per::Vertex,
            map: ColourMap::default(),
            range: Range::default(),
            log: false,
            bands: None,
            isolines: None,
            legend: None,
        }
    }

    /// One number per face, which has one colour.
    #[must_use]
    pub fn per_face(of: &'a [f64]) -> Self {
        Self { per: Per::Face, ..Self::per_vertex(of) }
    }

    /// Whether the same number shall have the same colour.
    fn is_comparable(&self, with: &Self) -> bool {
        Self { of: &[], per: Per::Vertex, isolines: None, ..*self }
            == Self { of: &[], per: Per::Vertex, isolines: None, ..*with }
    }

    pub(crate) fn check(&self) -> Result<(), RenderError> {
        let wrong = |what, value, range| Err(RenderError::Style { what, value, range });
        if let Some(bands) = self.bands.filter(|bands| !(1..=256).contains(bands)) {
            return wrong("the number of bands", f64::from(bands), "from 1 to 256");
        }
        let (ends, [low, high]) = match self.range {
            Range::Auto | Range::Full => return Ok(()),
            Range::Percentiles(low, high) => ("from 0 to 100", [low, high]),
            Range::Between(low, high) => ("finite", [low, high]),
        };
        let is_percentile = matches!(self.range, Range::Percentiles(..));
        for (what, value) in
            [("the low end of the values", low), ("the high end of the values", high)]
        {
            if !value.is_finite() || is_percentile && !(0.0..=100.0).contains(&value) {
                return wrong(what, value, ends);
            }
        }
        if high <= low {
            return wrong("the high end of the values", high, "above the low end");
        }
        if self.log && !is_percentile && low <= 0.0 {
            return wrong("the low end of the values", low, "positive on a logarithmic scale");
        }
        Ok(())
    }
}

/// What there is one value for.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Per {
    /// Each vertex.
    #[default]
    Vertex,
    /// Each face.
    Face,
}

/// Which numbers have the first and the last colour.
///
/// The first three look at the numbers. Under a diverging map they are as wide on both sides of zero
/// (of one on a logarithmic scale), under a cyclic map they take in all numbers.
///
/// Reads from text: `auto`, `full`, `2%..98%` or `-0.5..0.5`.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub enum Range {
    /// From the 2nd to the 98th percentile, so that a few wild numbers do not matter.
    #[default]
    Auto,
    /// From the least to the greatest.
    Full,
    /// From one percentile to another, 0 to 100. Under a diverging map the second is that of the
    /// sizes.
    Percentiles(f64, f64),
    /// From one number to another.
    Between(f64, f64),
}

/// A text is no range of values.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error(
    "`{0}` is no range of values: expected auto, full, percentiles such as 2%..98%, or two numbers \
     such as -0.5..0.5, the smaller first"
)]
pub struct ParseRangeError(String);

impl FromStr for Range {
    type Err = ParseRangeError;

    fn from_str(text: &str) -> Result<Self, ParseRangeError> {
        let range = || {
            if text == "auto" || text == "full" {
                return Some(if text == "auto" { Self::Auto } else { Self::Full });
            }
            let (low, high) = text.split_once("..")?;
            let number = |text: &str| text.trim().parse::<f64>().ok();
            let percent = |text: &str| number(text.trim().strip_suffix('%')?);
            match (percent(low), percent(high)) {
                (Some(low), Some(high)) => Some(Self::Percentiles(low, high)),
                _ => Some(Self::Between(number(low)?, number(high)?)),
            }
        };
        range()
            .filter(|&range| Values { range, ..Values::per_vertex(&[]) }.check().is_ok())
            .ok_or_else(|| ParseRangeError(text.chars().take(80).collect()))
    }
}

/// What each number looks like.
#[derive(Clone, PartialEq, Debug)]
#[expect(clippy::struct_excessive_bools, reason = "independent findings")]
pub(crate) struct Gauge {
    pub(crate) map: ColourMap,
    /// Of equal width, if any.
    pub(crate) bands: Option<u32>,
    /// In logarithms if `log`.
    pub(crate) scale: Scale,
    pub(crate) log: bool,
    /// What is written at the bar.
    pub(crate) legend: Option<String>,
    /// Whether there are numbers below and above the range, and ones that have no place.
    pub(crate) below: bool,
    pub(crate) above: bool,
    pub(crate) missing: bool,
}

impl Gauge {
    fn new(alike: &[&Values]) -> Self {
        let Values { map, range, log, bands, legend, .. } = *alike[0];
        let all = || alike.iter().flat_map(|v| v.of).map(|&v| reading(v, log));
        let mut finite: Vec<f64> = all().filter(|v| v.is_finite()).collect();
        let ends = |numbers: &mut Vec<f64>| match range {
            Range::Between(low, high) => (reading(low, log), reading(high, log)),
            Range::Percentiles(low, high) => percentiles(numbers, low, high),
            Range::Auto if map != ColourMap::Cyclic => percentiles(numbers, 2.0, 98.0),
            Range::Auto | Range::Full => percentiles(numbers, 0.0, 100.0),
        };
        let is_given = matches!(range, Range::Between(..));
        let (low, high) = if map.is_diverging() && !is_given {
            for v in &mut finite {
                *v = v.abs();
            }
            let (_, size) = ends(&mut finite);
            let size = if size > 1e-290 { size } else { 1.0 };
            (-size, size)
        } else {
            widened(ends(&mut finite))
        };
        let is_round = !is_given && !log && map != ColourMap::Cyclic;
        let banded = bands.filter(|_| is_round).and_then(|n| whole_bands(low, high, n));
        let (scale, bands) = match banded {
            Some((scale, bands)) => (scale, Some(bands)),
            None => (numbered(low, high, log), bands),
        };
        // By as much as can be seen in the colours.
        let room = 0.01 * (0.5 * scale.high - 0.5 * scale.low);
        let beyond =
            |is_beyond: &dyn Fn(f64) -> bool| map != ColourMap::Cyclic && all().any(is_beyond);
        Self {
            map,
            bands,
            below: beyond(&|v| 0.5 * v < 0.5 * scale.low - room),
            above: beyond(&|v| 0.5 * v > 0.5 * scale.high + room),
            missing: all().any(f64::is_nan),
            scale,
            log,
            legend: legend.map(String::from),
        }
    }

    /// From 0 to 1 within the range; a little beyond outside; NaN where there is no value.
    pub(crate) fn share(&self, value: f64) -> f32 {
        let Scale { low, high, .. } = self.scale;
        let v = reading(value, self.log);
        // Halved first: the difference of huge numbers overflows.
        let share = (0.5 * v - 0.5 * low) / (0.5 * high - 0.5 * low);
        if self.map == ColourMap::Cyclic && share.is_finite() {
            return (share - libm::floor(share)) as f32;
        }
        // Not so far beyond that the colours of a face with such a corner are all at an end.
        share.clamp(-4.0, 5.0) as f32
    }

    /// Where isolines are, from 0 to 1.
    pub(crate) fn levels(&self) -> Vec<f32> {
        match self.bands {
            Some(n) => (1..n).map(|i| i as f32 / n as f32).collect(),
            None => self.ticks().filter(|t| t.label.is_some()).map(|t| self.place(t)).collect(),
        }
    }

    /// The ticks within the range, in order.
    pub(crate) fn ticks(&self) -> impl Iterator<Item = &Tick> {
        self.scale.ticks.iter().filter(|t| (-1e-9..=1.0 + 1e-9).contains(&self.unclamped(t)))
    }

    fn unclamped(&self, tick: &Tick) -> f64 {
        let Scale { low, high, .. } = self.scale;
        (0.5 * tick.at - 0.5 * low) / (0.5 * high - 0.5 * low)
    }

    /// Where a tick is, from 0 to 1.
    pub(crate) fn place(&self, tick: &Tick) -> f32 {
        self.scale.share(tick.at) as f32
    }
}

/// The number that the scale is even in. Nothing at all is below every number of a logarithmic scale;
/// less than nothing is not on it.
fn reading(value: f64, log: bool) -> f64 {
    match log {
        false => value,
        true if value >= 0.0 => libm::log10(value),
        true => f64::NAN,
    }
}

/// The numbers that so many percent are not above; the least and the greatest where they agree.
fn percentiles(numbers: &mut [f64], low: f64, high: f64) -> (f64, f64) {
    let Some(last) = numbers.len().checked_sub(1) else { return (f64::NAN, f64::NAN) };
    #[expect(clippy::cast_sign_loss, reason = "a percentile is from 0 to 100")]
    let at = |numbers: &mut [f64], rank: f64| {
        *numbers.select_nth_unstable_by((rank as usize).min(last), f64::total_cmp).1
    };
    let rank = |percent: f64| percent / 100.0 * last as f64;
    let ends = (at(numbers, rank(low).floor()), at(numbers, rank(high).ceil()));
    if ends.0 < ends.1 {
        return ends;
    }
    (at(numbers, 0.0), at(numbers, last as f64))
}

/// A range of some width around one number; of any numbers if there is none.
fn widened((low, high): (f64, f64)) -> (f64, f64) {
    let Scale { low, high, .. } =
        Scale::linear([low, high].into_iter().filter(|v| !v.is_nan()), false);
    (low, high)
}

/// About `n` bands between round numbers.
fn whole_bands(low: f64, high: f64, n: u32) -> Option<(Scale, u32)> {
    let step = round_step((0.5 * high - 0.5 * low) / (0.5 * f64::from(n)));
    if !(step.is_finite() && step > 0.0) {
        return None;
    }
    let (first, last) = (libm::floor(low / step + 1e-9), libm::ceil(high / step - 1e-9));
    let bands = last - first;
    if !((1.0..=600.0).contains(&bands) && (first * step).is_finite() && (last * step).is_finite())
    {
        return None;
    }
    let every = [1, 2, 5, 10, 20, 50, 100].into_iter().find(|&k| bands <= 10.0 * f64::from(k))?;
    let scale = Scale::stepped(first * step, last * step, step * f64::from(every));
    #[expect(clippy::cast_sign_loss, reason = "not below 1")]
    Some((scale, bands as u32))
}

/// A scale from `low` to `high` with round numbers on it.
fn numbered(low: f64, high: f64, log: bool) -> Scale {
    if !log {
        let step = round_step((0.5 * high - 0.5 * low) / 2.5);
        let is_step = step.is_finite() && step > 0.0;
        let ticks = if is_step { Scale::stepped(low, high, step).ticks } else { Vec::new() };
        return Scale { low, high, ticks };
    }
    let mut scale = Scale::logarithmic([low, high].into_iter());
    scale.ticks.retain(|t| (low - 1e-9..=high + 1e-9).contains(&t.at));
    if scale.ticks.iter().filter(|t| t.label.is_some()).count() < 2 {
        // Within less than a decade plain numbers are rounder.
        let ends = [low, high].map(|v| libm::pow(10.0, v));
        scale.ticks = Scale::linear(ends.into_iter(), false).ticks;
        for tick in &mut scale.ticks {
            tick.at = libm::log10(tick.at);
        }
    }
    Scale { low, high, ..scale }
}

/// The gauges of all values of a picture.
pub(crate) struct Gauges {
    pub(crate) all: Vec<Gauge>,
    /// Per panel and body.
    of: Vec<Vec<Option<usize>>>,
}

impl Gauges {
    /// Values of a kind are measured together, in all panels if `shared`.
    pub(crate) fn new(panels: &[Panel], shared: bool) -> Self {
        let mut kinds: Vec<Vec<&Values>> = Vec::new();
        let mut of = Vec::with_capacity(panels.len());
        for panel in panels {
            let first = if shared { 0 } else { kinds.len() };
            let gauges = panel.bodies.iter().map(|body| {
                let values = body.values.as_ref()?;
                let known = kinds[first..].iter().position(|k| k[0].is_comparable(values));
                let kind = known.map_or(kinds.len(), |k| first + k);
                if kind == kinds.len() {
                    kinds.push(Vec::new());
                }
                kinds[kind].push(values);
                Some(kind)
            });
            of.push(gauges.collect());
        }
        Self { all: kinds.iter().map(|kind| Gauge::new(kind)).collect(), of }
    }

    /// The gauge of each body of a panel.
    pub(crate) fn of_bodies(&self, panel: usize) -> Vec<Option<&Gauge>> {
        self.of[panel].iter().map(|gauge| gauge.map(|g| &self.all[g])).collect()
    }

    /// The gauges of a panel that have a legend, each once.
    pub(crate) fn of_panel(&self, panel: usize) -> Vec<&Gauge> {
        let mut numbers: Vec<usize> = self.of[panel].iter().copied().flatten().collect();
        numbers.sort_unstable();
        numbers.dedup();
        numbers.into_iter().map(|g| &self.all[g]).filter(|g| g.legend.is_some()).collect()
    }

    /// The gauge that has the only legend of the picture.
    pub(crate) fn only(&self) -> Option<&Gauge> {
        let mut with_legend = self.all.iter().filter(|g| g.legend.is_some());
        with_legend.next().filter(|_| with_legend.next().is_none())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gauge(values: Values) -> Gauge {
        Gauge::new(&[&values])
    }

    fn labels(gauge: &Gauge) -> Vec<String> {
        gauge
            .ticks()
            .filter_map(|t| t.label.as_ref())
            .map(super::super::ticks::Label::text)
            .collect()
    }

    #[test]
    fn a_few_wild_numbers_do_not_stretch_the_range() {
        let mut of: Vec<f64> = (0..1000).map(|i| f64::from(i) / 1000.0).collect();
        (of[3], of[500], of[900]) = (1e30, -1e30, f64::NAN);
        let auto = gauge(Values::per_vertex(&of));
        assert!((auto.scale.low - 0.02).abs() < 3e-3 && (auto.scale.high - 0.98).abs() < 3e-3);
        assert!(auto.below && auto.above && auto.missing);
        let full = gauge(Values { range: Range::Full, ..Values::per_vertex(&of) });
        assert_eq!((full.scale.low, full.scale.high), (-1e30, 1e30));
        assert!(!full.below && !full.above);
        assert!(auto.share(f64::NAN).is_nan());
    }

    #[test]
    fn a_diverging_range_has_zero_in_the_middle() {
        let of: Vec<f64> = (-10..1000).map(|i| f64::from(i) / 1000.0).collect();
        for range in [Range::Auto, Range::Full, Range::Percentiles(0.0, 50.0)] {
            let map = ColourMap::CoolWarm;
            let gauge = gauge(Values { map, range, ..Values::per_vertex(&of) });
            assert_eq!(gauge.scale.low, -gauge.scale.high);
            assert_eq!(gauge.share(0.0), 0.5);
        }
    }

    #[test]
    fn borders_of_bands_are_round() {
        let of: Vec<f64> = (0..1000).map(|i| 0.0137 + f64::from(i) * 0.000_931).collect();
        let gauge = gauge(Values { bands: Some(10), ..Values::per_vertex(&of) });
        assert_eq!((gauge.scale.low, gauge.scale.high, gauge.bands), (0.0, 1.0, Some(10)));
        assert_eq!(labels(&gauge)[..3], ["0", "0.1", "0.2"]);
        let given = Range::Between(0.0, 1.0);
        let exact = self::gauge(Values { bands: Some(7), range: given, ..Values::per_vertex(&of) });
        assert_eq!(exact.bands, Some(7));
    }

    #[test]
    fn numbers_at_the_bar_are_round() {
        for (low, high, expected) in [
            (0.0, 1.0, &["0", "0.2", "0.4"][..]),
            (-0.37, 0.37, &["−0.3", "−0.2", "−0.1"]),
            (0.0012, 0.0043, &["0.0015", "0.0020", "0.0025"]),
            (1.3e9, 7.7e9, &["2×10⁹", "3×10⁹", "4×10⁹"]),
        ] {
            let range = Range::Between(low, high);
            let found = labels(&gauge(Values { range, ..Values::per_vertex(&[]) }));
            let found: Vec<&str> = found.iter().map(String::as_str).take(3).collect();
            assert_eq!(found, expected);
        }
    }

    #[test]
    fn a_logarithmic_scale_has_powers_of_ten() {
        let of = [0.0, 1e-6, 1e-4, 1e-2, -1.0];
        let values = Values { log: true, range: Range::Full, ..Values::per_vertex(&of) };
        let powers = gauge(values);
        assert_eq!(labels(&powers), ["10⁻⁶", "10⁻⁵", "10⁻⁴", "10⁻³", "10⁻²"]);
        assert!((powers.share(1e-4) - 0.5).abs() < 1e-6);
        assert!(powers.share(-1.0).is_nan() && powers.missing, "a negative number has no place");
        assert!(powers.share(0.0) < 0.0 && powers.below, "zero is below all");
        let narrow = gauge(Values { range: Range::Between(0.0022, 0.0045), ..values });
        assert_eq!(labels(&narrow)[..2], ["0.0025", "0.0030"]);
    }

    /// No numbers, one number, and the largest there are.
    #[test]
    fn any_numbers_give_a_range() {
        let cases: [&[f64]; 8] = [
            &[],
            &[f64::NAN],
            &[f64::INFINITY, f64::NEG_INFINITY],
            &[0.0; 5],
            &[-3.0; 5],
            &[f64::MAX, f64::MIN],
            &[5e-324, 0.0],
            &[1.0, 1.0 + 1e-16],
        ];
        for of in cases {
            for map in ColourMap::ALL {
                for (log, bands) in [(false, None), (true, None), (false, Some(8)), (true, Some(3))]
                {
                    let gauge = gauge(Values { map, log, bands, ..Values::per_vertex(of) });
                    assert!(gauge.scale.low < gauge.scale.high, "{of:?} {gauge:?}");
                    assert!(gauge.levels().windows(2).all(|w| w[0] <= w[1]), "{of:?} {gauge:?}");
                    let share = gauge.share(0.5 * (gauge.scale.low + gauge.scale.high));
                    assert!(log || share.is_finite(), "{of:?} {gauge:?}");
                }
            }
        }
    }

    #[test]
    fn ranges_are_read() {
        assert_eq!("auto".parse(), Ok(Range::Auto));
        assert_eq!("full".parse(), Ok(Range::Full));
        assert_eq!("5%..95%".parse(), Ok(Range::Percentiles(5.0, 95.0)));
        assert_eq!("-0.5 .. 1e-3".parse(), Ok(Range::Between(-0.5, 1e-3)));
        for text in ["", "1", "2..1", "1..1", "5%..7", "-1%..2%", "nan..1", "0..inf", "0%..101%"] {
            assert!(text.parse::<Range>().is_err(), "{text}");
        }
    }
}
