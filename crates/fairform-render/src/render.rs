//! [`render`]: panels to pixels.

use crate::camera::Camera;
use crate::canvas::{Canvas, Ink};
use crate::layout::{self, Layout, SUBTITLE, TITLE_LINES};
use crate::legend::{HEIGHT_BELOW, Pen};
use crate::light::Lights;
use crate::raster::{Bounds, Tile};
use crate::scene::{self, Panel, Scene};
use crate::shade::Shading;
use crate::text::Typeface;
use crate::values::{Gauge, Gauges};
use crate::{Colour, Picture, RenderError, View, par};

/// The most pixels of a side.
pub const MAX_SIDE: u32 = 16_384;
/// The most pixels of a picture.
pub const MAX_PIXELS: u32 = 1 << 26;

/// Choices that concern the whole picture.
#[derive(Clone, Copy, PartialEq, Debug)]
#[expect(clippy::struct_excessive_bools, reason = "independent switches")]
pub struct Options {
    /// What is behind everything; may be transparent.
    pub background: Colour,
    /// Whether bodies shade themselves and each other.
    pub shadows: bool,
    /// Whether a soft shadow lies below the bodies, as if they stood on a table of the colour of
    /// the background.
    pub ground: bool,
    /// Whether all panels have the same camera and scale, so that they can be compared; otherwise
    /// each is fitted on its own.
    pub shared: bool,
    /// Whether the same number has the same colour in all panels, where their values have the same
    /// colours, range and legend; otherwise each panel is measured on its own.
    pub shared_range: bool,
    /// Panels in a row; by default as many as make the panels largest.
    pub columns: Option<usize>,
    /// Height of the titles in thousandths of the shorter side of a panel, or of half that of the
    /// picture if this is more; the text at colour bars is somewhat smaller. 0 leaves out both.
    pub title_size: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            background: Colour::WHITE,
            shadows: true,
            ground: true,
            shared: true,
            shared_range: true,
            columns: None,
            title_size: 38.0,
        }
    }
}

/// A picture of panels side by side, `size` pixels wide and high.
///
/// Values with a legend have a colour bar: one at the right if there is only one kind of values,
/// otherwise each panel has its own below.
///
/// Takes time with the number of triangles and of pixels, about 1.6 s for 10⁵ triangles and
/// 10⁶ pixels on one core, and memory with both.
///
/// # Errors
/// If the size is beyond [`MAX_SIDE`] or [`MAX_PIXELS`] or leaves no room for the panels; a face
/// lists a vertex that does not exist; a vertex that is drawn is not finite; a stroke ends at one that
/// does not exist; there are not as many normals, colours or values as vertices, normals as corners, or values as faces; a
/// number of the view, a style or the options is out of its range.
pub fn render(
    panels: &[Panel],
    view: &View,
    size: (u32, u32),
    options: &Options,
) -> Result<Picture, RenderError> {
    let (width, height) = size;
    let sides = 1..=MAX_SIDE;
    if !(sides.contains(&width) && sides.contains(&height)) || width * height > MAX_PIXELS {
        return Err(RenderError::Size { width, height });
    }
    view.check()?;
    if !(0.0..=500.0).contains(&options.title_size) {
        let (value, range) = (options.title_size, "from 0 to 500");
        return Err(RenderError::Style { what: "the title size", value, range });
    }
    for (index, panel) in panels.iter().enumerate() {
        scene::check(panel, index)?;
    }
    let typeface = Typeface::new();
    let gauges = Gauges::new(panels, options.shared_range);
    let layout = Layout::new(panels, &gauges, &typeface, size, options)?;
    let mut canvas = Canvas::new(size, options.background);
    let together = options.shared.then(|| layout.fit(panels, view)).flatten();
    for (i, panel) in panels.iter().enumerate() {
        let own;
        let camera = if options.shared {
            &together
        } else {
            own = layout.fit(std::slice::from_ref(panel), view);
            &own
        };
        if let Some(camera) = camera {
            let stage = Stage { panel, gauges: &gauges.of_bodies(i), camera, view, options };
            stage.draw(&layout, layout.corner(i), &mut canvas);
        }
    }
    let ink = Ink::on(options.background);
    let mut pen = Pen { canvas: &mut canvas, typeface: &typeface, ink, size: layout.legend_size };
    draw_bars(panels.len(), &gauges, &layout, &mut pen);
    draw_titles(panels, &layout, &mut pen);
    Ok(Picture { width, height, pixels: canvas.pixels })
}

/// Rows and columns of a tile: few enough that its samples stay in the cache.
const TILE: [usize; 2] = [64, 32];

/// A panel and what is needed to draw it.
struct Stage<'a> {
    panel: &'a Panel<'a>,
    /// Per body.
    gauges: &'a [Option<&'a Gauge>],
    camera: &'a Camera,
    view: &'a View,
    options: &'a Options,
}

impl Stage<'_> {
    fn draw(&self, layout: &Layout, corner: [usize; 2], canvas: &mut Canvas) {
        let Self { panel, gauges, camera, view, options } = *self;
        let unit = layout.width.min(layout.height) as f64 / 1000.0;
        let scene = Scene::new(panel, gauges, camera, view.up, unit);
        // The vertical of the input as the camera sees it.
        let vertical = camera.turn(view.up.direction());
        let lights = Lights::new(&scene, vertical, options.shadows, options.ground);
        let background = options.background.linear();
        let bounds = Bounds::new(&scene);
        // Also behind the title, where the ground goes on.
        let (width, height) = (layout.width, layout.height + layout.strip);
        let size = [width as f64, height as f64];
        let shading = Shading { scene: &scene, lights: &lights, camera, background, size };
        // A stroke looks at the line in its middle, which may lie in the next tile.
        #[expect(clippy::cast_sign_loss, reason = "half a width")]
        let apron = scene.strokes.iter().map(|s| s.reach.ceil() as usize).max().unwrap_or(0);
        let rows = par::map(height.div_ceil(TILE[1]), |row| {
            let (top, bottom) = (row * TILE[1], (row * TILE[1] + TILE[1]).min(height));
            let around = [0, top.saturating_sub(apron), width, bottom + apron];
            let in_row = bounds.touching(None, around);
            par::map(width.div_ceil(TILE[0]), |column| {
                let (left, right) = (column * TILE[0], (column * TILE[0] + TILE[0]).min(width));
                let rectangle = [left, top, right, bottom];
                let drawn = [
                    left.saturating_sub(apron),
                    top.saturating_sub(apron),
                    (right + apron).min(width),
                    (bottom + apron).min(height),
                ];
                let parts = bounds.touching(Some(&in_row), drawn);
                let tile = Tile::draw(&scene, &parts, camera.focal, drawn);
                (rectangle, shading.pixels(&tile, rectangle))
            })
        });
        for ([left, top, right, _], pixels) in rows.into_iter().flatten() {
            canvas.put([corner[0] + left, corner[1] + top], right - left, &pixels);
        }
    }
}

fn draw_bars(panel_count: usize, gauges: &Gauges, layout: &Layout, pen: &mut Pen) {
    if pen.size <= 0.0 {
        return;
    }
    if layout.has_shared_bar {
        if let Some(gauge) = gauges.only() {
            pen.upright(gauge, layout.aside());
        }
        return;
    }
    for panel in 0..panel_count {
        let [left, mut top, width, _] = layout.below(panel);
        for gauge in gauges.of_panel(panel) {
            let height = HEIGHT_BELOW * pen.size;
            pen.lying(gauge, [left, top, width, height]);
            top += height;
        }
    }
}

fn draw_titles(panels: &[Panel], layout: &Layout, pen: &mut Pen) {
    let lines = || {
        let titles = panels.iter().enumerate().filter_map(|(i, p)| Some((i, p.title.as_deref()?)));
        titles.flat_map(|(i, title)| {
            title.lines().take(TITLE_LINES).enumerate().map(move |(line, text)| (i, line, text))
        })
    };
    // One size for all first lines, and one for all others.
    let room = 0.94 * layout.width as f32;
    let fitting = |is_first: bool, size: f32| {
        lines()
            .filter(|&(_, line, _)| (line == 0) == is_first)
            .map(|(_, _, text)| pen.typeface.fitting(text, size, room))
            .fold(size, f32::min)
    };
    let first = fitting(true, layout.title_size);
    let sizes = [first, fitting(false, SUBTITLE * layout.title_size).min(first)];
    for (panel, line, text) in lines() {
        let [left, top, width, _] = layout.title(panel);
        let base = top + layout::base_line(line) * layout.title_size;
        pen.write(text, sizes[line.min(1)], [left + 0.5 * width, base]);
    }
}
