//! [`Layout`]: where the panels, their titles and the colour bars are.

use crate::arrow::Extent;
use crate::camera::Camera;
use crate::legend;
use crate::scene::{self, Panel};
use crate::text::Typeface;
use crate::values::Gauges;
use crate::{Options, RenderError, View};

/// A rectangle in pixels: left, top, width, height.
pub(crate) type Rectangle = [f32; 4];

/// Where the parts of a picture are, in pixels.
pub(crate) struct Layout {
    columns: usize,
    /// Of a panel without what is below it.
    pub(crate) width: usize,
    pub(crate) height: usize,
    /// Height of the strip for colour bars and the title below.
    pub(crate) strip: usize,
    /// Height of what all bars below a panel take of it.
    bars: f32,
    /// Height of the first line of a title.
    pub(crate) title_size: f32,
    /// Height of the text at colour bars.
    pub(crate) legend_size: f32,
    /// Whether one bar at the right is for all panels.
    pub(crate) has_shared_bar: bool,
    size: [usize; 2],
}

/// Height of the lines of a title after the first.
pub(crate) const SUBTITLE: f32 = 0.74;
/// Lines of a title that are shown.
pub(crate) const TITLE_LINES: usize = 4;
/// Distance of the base lines, in heights of the text.
const LEADING: f64 = 1.18;

impl Layout {
    #[expect(clippy::cast_sign_loss, reason = "the title size is checked")]
    pub(crate) fn new(
        panels: &[Panel],
        gauges: &Gauges,
        typeface: &Typeface,
        (width, height): (u32, u32),
        options: &Options,
    ) -> Result<Self, RenderError> {
        let no_room = RenderError::NoRoom { panels: panels.len(), width, height };
        let [width, height] = [width as usize, height as usize];
        let count = panels.len().max(1);
        // Bars of the same kind in all panels, or all of one panel, need not be repeated.
        let shared = gauges.only().filter(|_| options.title_size > 0.0);
        let has_shared_bar = shared.is_some();
        let share = options.title_size / 1000.0;
        // Many small panels have text that can still be read.
        let measure = |panel: usize| share * (0.5 * width.min(height) as f64).max(panel as f64);
        let legend_size = |panel: usize| (0.86 * measure(panel)) as f32;
        // The bar takes at most a third of the width, in which all is drawn that fits.
        let aside = |panel: usize| {
            let bar = shared.map_or(0.0, |g| legend::width_aside(g, typeface, legend_size(panel)));
            (bar.ceil() as usize).min(width / 3)
        };
        let rows = |columns: usize| height / count.div_ceil(columns);
        let shorter = |columns: usize| {
            let without = (width / columns).min(rows(columns));
            ((width - aside(without)) / columns).min(rows(columns))
        };
        let columns = match options.columns {
            Some(columns) => columns.clamp(1, count),
            // More columns win if the panels get no smaller.
            None => (1..=count.min(width)).max_by_key(|&columns| shorter(columns)).unwrap_or(1),
        };
        let without = (width / columns).min(rows(columns));
        let (aside, legend_size) = (aside(without), legend_size(without));
        let title_size = measure(shorter(columns));
        let lines = |panel: &Panel| {
            panel.title.as_ref().map_or(0, |title| title.lines().count().clamp(1, TITLE_LINES))
        };
        let title = match panels.iter().map(lines).max().unwrap_or(0) {
            0 => 0.0,
            n => (1.9 + (n - 1) as f64 * LEADING * f64::from(SUBTITLE)) * title_size,
        };
        let bars = if has_shared_bar || options.title_size == 0.0 {
            0
        } else {
            (0..panels.len()).map(|p| gauges.of_panel(p).len()).max().unwrap_or(0)
        };
        let bars = bars as f32 * legend::HEIGHT_BELOW * legend_size;
        let strip = (f64::from(bars) + title).round() as usize;
        let (panel_width, panel_height) =
            ((width - aside) / columns, rows(columns).saturating_sub(strip));
        if panel_width == 0 || panel_height == 0 {
            return Err(no_room);
        }
        Ok(Self {
            columns,
            width: panel_width,
            height: panel_height,
            strip,
            bars,
            title_size: title_size as f32,
            legend_size,
            has_shared_bar,
            size: [width, height],
        })
    }

    /// Left and top of a panel.
    pub(crate) fn corner(&self, panel: usize) -> [usize; 2] {
        let (column, row) = (panel % self.columns, panel / self.columns);
        [column * self.width, row * (self.height + self.strip)]
    }

    /// Where the title of a panel goes.
    pub(crate) fn title(&self, panel: usize) -> Rectangle {
        let [left, top, width, height] = self.below(panel);
        [left, top + self.bars, width, height - self.bars]
    }

    /// Where the bars of a panel go, and its title below them.
    pub(crate) fn below(&self, panel: usize) -> Rectangle {
        let [left, top] = self.corner(panel);
        [left as f32, (top + self.height) as f32, self.width as f32, self.strip as f32]
    }

    /// Where the bar for all panels goes.
    pub(crate) fn aside(&self) -> Rectangle {
        let left = self.columns * self.width;
        // Centred beside the surfaces of a single row, else beside all rows.
        let height = if self.size[1] < 2 * self.height { self.height } else { self.size[1] };
        [left as f32, 0.0, (self.size[0] - left) as f32, height as f32]
    }

    /// The camera that has the panels in its frame.
    pub(crate) fn fit(&self, panels: &[Panel], view: &View) -> Option<Camera> {
        let shorter = self.width.min(self.height) as f64;
        let dots = panels.iter().flat_map(|p| &p.bodies).filter_map(|b| b.style.points);
        let dot = dots.map(|d| d.radius).fold(0.0, f64::max);
        let arrows = panels.iter().flat_map(|p| &p.bodies).flat_map(|b| b.arrows);
        let arrow = arrows.fold(0.0, |most, a| match a.length {
            Extent::Picture(length) => length.max(most),
            Extent::Space(_) => most,
        });
        let margin = shorter * (0.06 + dot / 1000.0).max(0.01 + arrow / 1000.0);
        let size = [self.width as f64, self.height as f64];
        Camera::fit(panels.iter().flat_map(scene::seen), view, size, margin)
    }
}

/// Base line of a line of a title in its rectangle, from the top, in heights of the first line.
pub(crate) fn base_line(line: usize) -> f32 {
    1.25 + line as f32 * LEADING as f32 * SUBTITLE
}
