//! [`render`]: panels to pixels.

use crate::camera::Camera;
use crate::light::Lights;
use crate::raster::{Bounds, Tile};
use crate::scene::{self, Panel, Scene};
use crate::shade::Shading;
use crate::text::Typeface;
use crate::{Colour, Picture, RenderError, View, par};

/// The most pixels of a side.
pub const MAX_SIDE: u32 = 16_384;
/// The most pixels of a picture.
pub const MAX_PIXELS: u32 = 1 << 26;

/// Choices that concern the whole picture.
#[derive(Clone, Copy, PartialEq, Debug)]
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
    /// Panels in a row; by default as many as make the panels largest.
    pub columns: Option<usize>,
    /// Height of the titles in thousandths of the shorter side of a panel.
    pub title_size: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            background: Colour::WHITE,
            shadows: true,
            ground: true,
            shared: true,
            columns: None,
            title_size: 38.0,
        }
    }
}

/// A picture of panels side by side, `size` pixels wide and high.
///
/// Takes time with the number of triangles and of pixels, about 1.6 s for 10⁵ triangles and
/// 10⁶ pixels on one core, and memory with both.
///
/// # Errors
/// If the size is beyond [`MAX_SIDE`] or [`MAX_PIXELS`] or leaves no room for the panels; a face
/// lists a vertex that does not exist; a vertex that is drawn is not finite; there are not as many
/// normals or colours as vertices; a number of the view, a style or the options is out of its range.
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
    let layout = Layout::new(panels, size, options)?;
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
            draw_panel(panel, camera, view, options, &layout, layout.corner(i), &mut canvas);
        }
    }
    draw_titles(panels, &layout, options.background, &mut canvas);
    Ok(Picture { width, height, pixels: canvas.pixels })
}

/// Where the panels are.
struct Layout {
    columns: usize,
    /// Of a panel without its title, in pixels.
    width: usize,
    height: usize,
    /// Height of the strip for the title below.
    strip: usize,
    /// Height of a line of the title.
    title_size: f32,
}

impl Layout {
    #[expect(clippy::cast_sign_loss, reason = "the title size is checked")]
    fn new(panels: &[Panel], size: (u32, u32), options: &Options) -> Result<Self, RenderError> {
        let [width, height] = [size.0 as usize, size.1 as usize];
        let no_room = RenderError::NoRoom { panels: panels.len(), width: size.0, height: size.1 };
        let count = panels.len().max(1);
        let shorter = |columns: usize| (width / columns).min(height / count.div_ceil(columns));
        let columns = match options.columns {
            Some(columns) => columns.clamp(1, count),
            // More columns win if the panels get no smaller.
            None => (1..=count.min(width)).max_by_key(|&columns| shorter(columns)).unwrap_or(1),
        };
        let cell = height / count.div_ceil(columns);
        let size = options.title_size / 1000.0 * shorter(columns) as f64;
        let has_titles = panels.iter().any(|p| p.title.is_some());
        let strip = if has_titles { (1.9 * size).round() as usize } else { 0 };
        let (width, height) = (width / columns, cell.saturating_sub(strip));
        if width == 0 || height == 0 {
            return Err(no_room);
        }
        Ok(Self { columns, width, height, strip, title_size: size as f32 })
    }

    /// Left and top of a panel.
    fn corner(&self, panel: usize) -> [usize; 2] {
        let (column, row) = (panel % self.columns, panel / self.columns);
        [column * self.width, row * (self.height + self.strip)]
    }

    fn fit(&self, panels: &[Panel], view: &View) -> Option<Camera> {
        let shorter = self.width.min(self.height) as f64;
        let dots = panels.iter().flat_map(|p| &p.bodies).filter_map(|b| b.style.points);
        let dot = dots.map(|d| d.radius).fold(0.0, f64::max);
        let margin = shorter * (0.06 + dot / 1000.0);
        let size = [self.width as f64, self.height as f64];
        Camera::fit(panels.iter().flat_map(scene::seen), view, size, margin)
    }
}

struct Canvas {
    width: usize,
    pixels: Vec<[u8; 4]>,
}

impl Canvas {
    fn new((width, height): (u32, u32), background: Colour) -> Self {
        let [r, g, b, a] = background.linear();
        #[expect(clippy::cast_sign_loss, reason = "clamped to 0..1")]
        let opacity = (a * 255.0).round() as u8;
        let empty = [r, g, b].map(crate::colour::encode);
        let pixel = if opacity == 0 { [0; 4] } else { [empty[0], empty[1], empty[2], opacity] };
        let (width, height) = (width as usize, height as usize);
        Self { width, pixels: vec![pixel; width * height] }
    }
}

/// Rows and columns of a tile: few enough that its samples stay in the cache.
const TILE: [usize; 2] = [64, 32];

fn draw_panel(
    panel: &Panel,
    camera: &Camera,
    view: &View,
    options: &Options,
    layout: &Layout,
    corner: [usize; 2],
    canvas: &mut Canvas,
) {
    let unit = layout.width.min(layout.height) as f64 / 1000.0;
    let scene = Scene::new(panel, camera, unit);
    // The vertical of the input as the camera sees it.
    let vertical = match view.up {
        crate::Axis::X => [1.0, 0.0, 0.0],
        crate::Axis::Y => [0.0, 1.0, 0.0],
        crate::Axis::Z => [0.0, 0.0, 1.0],
    };
    let lights = Lights::new(&scene, camera.turn(vertical.into()), options.shadows, options.ground);
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
        let in_row = bounds.touching(None, [0, top.saturating_sub(apron), width, bottom + apron]);
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
        for (y, row) in pixels.chunks_exact(right - left).enumerate() {
            let at = (corner[1] + top + y) * canvas.width + corner[0] + left;
            canvas.pixels[at..at + row.len()].copy_from_slice(row);
        }
    }
}

fn draw_titles(panels: &[Panel], layout: &Layout, background: Colour, canvas: &mut Canvas) {
    if layout.strip == 0 {
        return;
    }
    let typeface = Typeface::new();
    let titles = || panels.iter().enumerate().filter_map(|(i, p)| Some((i, p.title.as_deref()?)));
    // One size for all.
    let room = 0.94 * layout.width as f32;
    let size = titles()
        .map(|(_, title)| typeface.fitting(title, layout.title_size, room))
        .fold(layout.title_size, f32::min);
    let is_dark =
        background.a > 0.5 && 0.3 * background.r + 0.6 * background.g + 0.1 * background.b < 0.45;
    let ink = if is_dark { Colour::hex(0xf0_f2_f5) } else { Colour::INK };
    let ink = [ink.r, ink.g, ink.b].map(|c| c as f32 * 255.0);
    for (i, title) in titles() {
        let [left, top] = layout.corner(i);
        let middle = left as f32 + 0.5 * layout.width as f32;
        let base = (top + layout.height) as f32 + 0.5 * layout.strip as f32 + 0.3 * size;
        typeface.draw(title, size, [middle, base], |x, y, coverage| {
            let x = usize::try_from(x).ok().filter(|x| (left..left + layout.width).contains(x));
            let y = usize::try_from(y).ok();
            let (Some(x), Some(y)) = (x, y) else { return };
            if let Some(pixel) = canvas.pixels.get_mut(y * canvas.width + x) {
                *pixel = inked(*pixel, ink, coverage);
            }
        });
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
