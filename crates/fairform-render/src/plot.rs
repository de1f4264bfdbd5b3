//! Plots.
/// A curve.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Series {
    /// n
    pub name: String,
    /// p
    pub points: Vec<(f64, f64)>,
    /// d
    pub dashed: bool,
}
/// Plot.
#[must_use]
pub fn plot_svg(_s: &[Series], _t: &str, _x: &str, _y: &str, _l: bool) -> String {
    String::new()
}
