//! [`Scale`]: where the numbers of an axis are, and what is written there.

/// An axis: its range, and what is written where.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Scale {
    pub(crate) low: f64,
    pub(crate) high: f64,
    pub(crate) ticks: Vec<Tick>,
}

#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Tick {
    pub(crate) at: f64,
    /// `None` for a faint line without a number.
    pub(crate) label: Option<Label>,
}

/// A number as it is written, `digits` or `digits × 10^exponent`.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Label {
    digits: String,
    exponent: Option<i32>,
}

impl Scale {
    fn range(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
        values.fold(None, |range, v| {
            let (low, high) = range.unwrap_or((v, v));
            Some((v.min(low), v.max(high)))
        })
    }

    /// Equal steps of 1, 2 or 5 times a power of ten, with whole steps at the ends if `round`.
    pub(crate) fn linear(values: impl Iterator<Item = f64>, round: bool) -> Self {
        let (mut low, mut high) = Self::range(values).unwrap_or((0.0, 1.0));
        let size = low.abs().max(high.abs());
        // Halved first: the difference of huge numbers overflows.
        if 0.5 * high - 0.5 * low <= 1e-12 * size || size < 1e-290 {
            let room = if size < 1e-290 { 1.0 } else { 0.5 * size };
            (low, high) = ((low - room).max(f64::MIN), (high + room).min(f64::MAX));
        }
        let step = round_step((0.5 * high - 0.5 * low) / 3.0);
        if !(step.is_finite() && step > 0.0) {
            return Self { low, high, ticks: Vec::new() };
        }
        if round {
            let (begin, end) = (libm::floor(low / step), libm::ceil(high / step));
            if (begin * step).is_finite() && (end * step).is_finite() {
                (low, high) = (begin * step, end * step);
            }
        }
        Self::stepped(low, high, step)
    }

    /// From `low` to `high` with ticks at the multiples of `step`, which is 1, 2 or 5 times a power of
    /// ten, or a multiple of such a number.
    pub(crate) fn stepped(low: f64, high: f64, step: f64) -> Self {
        // Ends that are whole steps but for rounding count.
        let near = 1e-9;
        let (first, last) = (libm::ceil(low / step - near), libm::floor(high / step + near));
        // Where numbers are so close that steps round away, there may be fewer.
        let count = (last - first).clamp(0.0, 20.0) as i32;
        let exponent = libm::floor(libm::log10(step) + 1e-9) as i32;
        let top = libm::floor(libm::log10(low.abs().max(high.abs())) + 1e-9) as i32;
        let ticks = (0..=count)
            .map(|i| {
                let steps = first + f64::from(i);
                let label = Label::linear(steps, steps * step, exponent, top);
                Tick { at: steps * step, label: Some(label) }
            })
            .collect();
        Self { low, high, ticks }
    }

    /// Whole decades; `values` are logarithms.
    pub(crate) fn logarithmic(values: impl Iterator<Item = f64>) -> Self {
        let (low, high) = Self::range(values).unwrap_or((-1.0, 0.0));
        let mut first = libm::floor(low + 1e-9) as i32;
        let mut last = libm::ceil(high - 1e-9) as i32;
        if first >= last {
            (first, last) = (first - 1, first + 1);
        }
        // At most a dozen numbers.
        let decades = last - first;
        let step = [1, 2, 3, 5, 10, 20, 50].into_iter().find(|s| decades <= 11 * s).unwrap_or(100);
        let mut ticks = Vec::new();
        for decade in first..=last {
            let label = (decade.rem_euclid(step) == 0)
                .then(|| Label { digits: String::new(), exponent: Some(decade) });
            ticks.push(Tick { at: f64::from(decade), label });
            if decades <= 3 && decade < last {
                ticks.extend((2..10).map(|k| {
                    let digits = if decades == 1 && (k == 2 || k == 5) {
                        k.to_string()
                    } else {
                        String::new()
                    };
                    let label =
                        (!digits.is_empty()).then_some(Label { digits, exponent: Some(decade) });
                    Tick { at: f64::from(decade) + libm::log10(f64::from(k)), label }
                }));
            }
        }
        if decades > 30 {
            ticks.retain(|t| t.label.is_some());
        }
        Self { low: f64::from(first), high: f64::from(last), ticks }
    }

    /// From 0 at the low end to 1 at the high end.
    pub(crate) fn share(&self, value: f64) -> f64 {
        let share = (0.5 * value - 0.5 * self.low) / (0.5 * self.high - 0.5 * self.low);
        share.clamp(0.0, 1.0)
    }
}

/// The number nearest to `rough` among 1, 2 and 5 times the powers of ten; not finite or zero where
/// numbers end.
pub(crate) fn round_step(rough: f64) -> f64 {
    let power = libm::pow(10.0, libm::floor(libm::log10(rough)));
    power
        * match rough / power {
            r if r < 1.5 => 1.0,
            r if r < 3.5 => 2.0,
            r if r < 7.5 => 5.0,
            _ => 10.0,
        }
}

impl Label {
    /// `exponent` is that of the step, `top` that of the largest number on the axis.
    fn linear(steps: f64, value: f64, exponent: i32, top: i32) -> Self {
        if steps == 0.0 {
            return Self { digits: "0".into(), exponent: None };
        }
        if (-4..6).contains(&top) && exponent > -9 {
            let decimals = usize::try_from(-exponent).unwrap_or(0);
            return Self { digits: format!("{value:.decimals$}"), exponent: None };
        }
        let decimals = usize::try_from(top - exponent).unwrap_or(0).min(15);
        // In two steps, since the power itself may overflow.
        let half = libm::pow(10.0, f64::from(top / 2));
        let digits = value / half / libm::pow(10.0, f64::from(top - top / 2));
        Self { digits: format!("{digits:.decimals$}"), exponent: Some(top) }
    }

    /// As it is read, with the exponent raised.
    pub(crate) fn text(&self) -> String {
        let minus = |text: &str| text.replace('-', "−");
        let digits = minus(&self.digits);
        let Some(exponent) = self.exponent else { return digits };
        let times = if digits.is_empty() { "" } else { "×" };
        let raised: String = exponent.to_string().chars().map(raised).collect();
        format!("{digits}{times}10{raised}")
    }
}

/// A sign or digit as a superscript of its own: raised runs of text are placed differently by
/// different readers of SVG.
fn raised(c: char) -> char {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    match c.to_digit(10) {
        Some(digit) => DIGITS[digit as usize],
        None => '⁻',
    }
}
