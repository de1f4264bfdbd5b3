//! What is nearest at sixteen places of every pixel of a [`Tile`].

use crate::scene::{Ball, Scene, Stroke};

/// Places in a pixel.
pub(crate) const SAMPLES: usize = 16;

/// Where they are, from the middle of the pixel: no two in the same column or row, so that an edge
/// near either direction still has sixteen steps. \[Direct3D standard multisample pattern\]
pub(crate) const OFFSETS: [[f32; 2]; SAMPLES] = {
    const SIXTEENTHS: [[i8; 2]; SAMPLES] = [
        [1, 1],
        [-1, -3],
        [-3, 2],
        [4, -1],
        [-5, -2],
        [2, 5],
        [5, 3],
        [3, -5],
        [-2, 6],
        [0, -7],
        [-4, -6],
        [-6, 4],
        [-8, 0],
        [7, -4],
        [6, 7],
        [-7, -8],
    ];
    let mut offsets = [[0.0; 2]; SAMPLES];
    let mut i = 0;
    while i < SAMPLES {
        let [x, y] = SIXTEENTHS[i];
        offsets[i] = [(x as f32 + 0.5) / 16.0, (y as f32 + 0.5) / 16.0];
        i += 1;
    }
    offsets
};

/// Nothing is there.
pub(crate) const NONE: u32 = u32::MAX;

/// A linear function of the place in the picture: `[a, b, c]` is $`a x + b y + c`$.
type Linear = [f64; 3];

fn value([a, b, c]: Linear, x: f64, y: f64) -> f64 {
    a * x + b * y + c
}

/// A triangle on the screen.
pub(crate) struct Setup {
    /// Positive inside; zero at the side opposite to each corner; two triangles at a side agree to
    /// the last bit.
    edges: [Linear; 3],
    area: f64,
    corners: [[f64; 3]; 3],
    /// Whether it turns counter-clockwise in the picture.
    pub(crate) front: bool,
}

impl Setup {
    /// `None` for a triangle seen from the side.
    pub(crate) fn new(scene: &Scene, triangle: usize) -> Option<Self> {
        let corners = scene.triangles[triangle].corners;
        let p = corners.map(|c| scene.screen[c as usize]);
        let area =
            (p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) - (p[1][1] - p[0][1]) * (p[2][0] - p[0][0]);
        if !(area.abs() > 1e-12 && area.is_finite()) {
            return None;
        }
        let edges = [0, 1, 2].map(|i| {
            let (i, j) = ((i + 1) % 3, (i + 2) % 3);
            // Always from the lower number, so that the neighbour computes the same.
            let (a, b, sign) =
                if corners[i] < corners[j] { (p[i], p[j], 1.0) } else { (p[j], p[i], -1.0) };
            let sign = sign * area.signum();
            let (dx, dy) = (sign * (b[0] - a[0]), sign * (b[1] - a[1]));
            [-dy, dx, dy * a[0] - dx * a[1]]
        });
        // Rows go down, which turns counter-clockwise around.
        Some(Self { edges, area: area.abs(), corners: p, front: area < 0.0 })
    }

    /// One over the depth.
    fn depth_plane(&self) -> Linear {
        std::array::from_fn(|k| {
            (0..3).map(|i| self.corners[i][2] * self.edges[i][k]).sum::<f64>() / self.area
        })
    }

    /// Weights of the corners at the place of the triangle's plane that is seen at `x`, `y`, inside or
    /// not; `None` where the plane is behind the eye.
    pub(crate) fn weights_around(&self, x: f64, y: f64) -> Option<[f64; 3]> {
        let w: [f64; 3] = std::array::from_fn(|i| value(self.edges[i], x, y) * self.corners[i][2]);
        let sum = w[0] + w[1] + w[2];
        (sum > 0.0).then(|| w.map(|w| w / sum))
    }

    /// Weights of the corners at the place that is seen at `x`, `y`.
    pub(crate) fn weights(&self, x: f64, y: f64) -> [f64; 3] {
        let w: [f64; 3] =
            std::array::from_fn(|i| value(self.edges[i], x, y).max(0.0) * self.corners[i][2]);
        let sum = w[0] + w[1] + w[2];
        if sum > 0.0 { w.map(|w| w / sum) } else { [1.0 / 3.0; 3] }
    }
}

/// A rectangle of the picture.
pub(crate) struct Tile {
    /// First column and row, and how many, in pixels.
    pub(crate) left: usize,
    pub(crate) top: usize,
    pub(crate) width: usize,
    pub(crate) height: usize,
    /// Per sample: one over the depth of the nearest surface, and which triangle, or ball after
    /// all triangles.
    pub(crate) near: Vec<[f32; SAMPLES]>,
    pub(crate) id: Vec<[u32; SAMPLES]>,
    /// Per sample: the ink drawn there; empty if there is none at all.
    pub(crate) stroke: Vec<[Inks; SAMPLES]>,
}

/// Ink of a stroke, or of what shows through, see [`Scene::ink`].
#[derive(Clone, Copy)]
pub(crate) struct Ink {
    pub(crate) id: u32,
    /// One over the depth.
    near: f32,
}

/// What is seen of all ink at a sample: the nearest, and the next that looks otherwise, which is seen
/// if the first lets it through. The same ink twice, as where two strokes of a line meet, counts once.
#[derive(Clone, Copy)]
pub(crate) struct Inks {
    pub(crate) top: Ink,
    pub(crate) below: Ink,
}

impl Inks {
    const NONE: Self = {
        let none = Ink { id: NONE, near: 0.0 };
        Self { top: none, below: none }
    };

    /// Adds ink that counts as being at `1 / raised`, before that of the same depth.
    fn add(&mut self, ink: Ink, raised: f32, scene: &Scene) {
        let [new, old] = [ink.id, self.top.id].map(|id| scene.is_ghost(id));
        let same = old == new && scene.ink(ink.id) == scene.ink(self.top.id);
        let wins = if new == old { raised >= self.top.near } else { old };
        if wins {
            if !same && self.top.id != NONE {
                self.below = self.top;
            }
            self.top = ink;
        } else if !same && raised >= self.below.near {
            self.below = ink;
        }
    }
}

/// Bounds in pixels of the parts of a scene.
pub(crate) struct Bounds {
    triangles: Vec<[f32; 4]>,
    balls: Vec<[f32; 4]>,
    strokes: Vec<[f32; 4]>,
}

impl Bounds {
    pub(crate) fn new(scene: &Scene) -> Self {
        let around = |points: &[u32], reach: f32| {
            let mut bounds = [f32::INFINITY, f32::INFINITY, f32::NEG_INFINITY, f32::NEG_INFINITY];
            for &p in points {
                let [x, y, _] = scene.screen[p as usize].map(|c| c as f32);
                bounds = [bounds[0].min(x), bounds[1].min(y), bounds[2].max(x), bounds[3].max(y)];
            }
            let reach = reach + 0.01;
            [bounds[0] - reach, bounds[1] - reach, bounds[2] + reach, bounds[3] + reach]
        };
        Self {
            triangles: scene.triangles.iter().map(|t| around(&t.corners, 0.0)).collect(),
            balls: scene.balls.iter().map(|b| around(&[b.point], b.radius)).collect(),
            strokes: scene.strokes.iter().map(|s| around(&s.ends, s.reach)).collect(),
        }
    }

    /// The parts that touch a rectangle: triangles, balls, strokes, each in order.
    pub(crate) fn touching(&self, among: Option<&Parts>, rectangle: [usize; 4]) -> Parts {
        let [left, top, right, bottom] = rectangle.map(|x| x as f32);
        let touches = |b: &[f32; 4]| b[0] < right && b[2] > left && b[1] < bottom && b[3] > top;
        let choose = |all: &[[f32; 4]], among: Option<&Vec<u32>>| match among {
            Some(among) => among.iter().copied().filter(|&i| touches(&all[i as usize])).collect(),
            None => (0..all.len() as u32).filter(|&i| touches(&all[i as usize])).collect(),
        };
        Parts {
            triangles: choose(&self.triangles, among.map(|p| &p.triangles)),
            balls: choose(&self.balls, among.map(|p| &p.balls)),
            strokes: choose(&self.strokes, among.map(|p| &p.strokes)),
        }
    }
}

/// Numbers of triangles, balls and strokes.
pub(crate) struct Parts {
    triangles: Vec<u32>,
    balls: Vec<u32>,
    strokes: Vec<u32>,
}

impl Tile {
    pub(crate) fn draw(
        scene: &Scene,
        parts: &Parts,
        focal: f64,
        [left, top, right, bottom]: [usize; 4],
    ) -> Self {
        let (width, height) = (right - left, bottom - top);
        let count = width * height;
        let has_ghosts = parts.balls.iter().any(|&b| scene.balls[b as usize].through > 0.0);
        let strokes = if parts.strokes.is_empty() && !has_ghosts { 0 } else { count };
        let mut tile = Self {
            left,
            top,
            width,
            height,
            near: vec![[0.0; SAMPLES]; count],
            id: vec![[NONE; SAMPLES]; count],
            stroke: vec![[Inks::NONE; SAMPLES]; strokes],
        };
        tile.draw_triangles(scene, &parts.triangles);
        for &b in &parts.balls {
            let id = scene.triangles.len() as u32 + b;
            tile.draw_ball(&scene.balls[b as usize], scene, id, focal as f32);
        }
        if has_ghosts {
            for &b in &parts.balls {
                tile.draw_ghost(&scene.balls[b as usize], scene, b, focal as f32);
            }
        }
        for &s in &parts.strokes {
            tile.draw_stroke(&scene.strokes[s as usize], s, scene, focal as f32);
        }
        tile
    }

    /// From near to far, so that the far ones can be left out once all is covered.
    fn draw_triangles(&mut self, scene: &Scene, triangles: &[u32]) {
        let (left, top) = (self.left as f64, self.top as f64);
        let (right, bottom) = (left + self.width as f64, top + self.height as f64);
        let corners = [[left, top], [right, top], [left, bottom], [right, bottom]];
        let mut order: Vec<(f32, u32)> = triangles
            .iter()
            .filter_map(|&t| {
                let setup = Setup::new(scene, t as usize)?;
                let most =
                    |f| corners.map(|[x, y]| value(f, x, y)).into_iter().fold(f64::MIN, f64::max);
                let passes_by = setup.edges.into_iter().any(|edge| most(edge) < 0.0);
                let [a, b, c] = setup.corners.map(|p| p[2]);
                // The nearest that it can be in the tile.
                let near = a.max(b).max(c).min(most(setup.depth_plane()).max(a.min(b).min(c)));
                (!passes_by).then_some((near as f32, t))
            })
            .collect();
        order.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let mut drawn = 0;
        for (nearest, t) in order {
            if drawn > 2 * self.near.len() {
                drawn = 0;
                let farthest =
                    self.near.as_flattened().iter().copied().fold(f32::INFINITY, f32::min);
                if nearest < farthest {
                    break;
                }
            }
            if let Some(setup) = Setup::new(scene, t as usize) {
                drawn += self.draw_triangle(&setup, t, covered_samples(scene, t as usize, &setup));
            }
        }
    }

    /// Columns and rows of the tile that a range of the picture touches.
    #[expect(clippy::cast_sign_loss, reason = "clamped to the tile")]
    fn clip(low: f64, high: f64, start: usize, count: usize) -> std::ops::Range<usize> {
        let end = count as f64;
        let first = (low - start as f64).floor().clamp(0.0, end);
        let last = (high - start as f64).ceil().clamp(0.0, end);
        first as usize..last as usize
    }

    /// Returns how many pixels it looked at.
    fn draw_triangle(&mut self, setup: &Setup, id: u32, samples: u16) -> usize {
        let plane = setup.depth_plane();
        let steps = |[a, b, _]: Linear| OFFSETS.map(|[x, y]| a as f32 * x + b as f32 * y);
        let mut edge_steps = setup.edges.map(steps);
        for (k, step) in edge_steps[0].iter_mut().enumerate() {
            if samples & (1 << k) == 0 {
                *step = f32::NEG_INFINITY;
            }
        }
        let near_steps = steps(plane);
        let reach = setup.edges.map(|[a, b, _]| 0.5 * (a.abs() + b.abs()));

        let range = |k: usize| {
            let [a, b, c] = setup.corners.map(|p| p[k]);
            (a.min(b).min(c), a.max(b).max(c))
        };
        let ([left, top, far], [right, bottom, near]) = {
            let [x, y, z] = [0, 1, 2].map(range);
            ([x.0, y.0, z.0], [x.1, y.1, z.1])
        };
        let (farthest, nearest) = (far as f32, near as f32);
        let columns = Self::clip(left - 0.01, right + 0.01, self.left, self.width);
        let rows = Self::clip(top - 0.01, bottom + 0.01, self.top, self.height);
        for row in rows.clone() {
            let y = (self.top + row) as f64 + 0.5;
            for column in columns.clone() {
                let x = (self.left + column) as f64 + 0.5;
                let middle = setup.edges.map(|e| value(e, x, y));
                if (0..3).any(|i| middle[i] < -reach[i]) {
                    continue;
                }
                let middle = middle.map(|m| m as f32);
                let near_middle = value(plane, x, y) as f32;
                let at = row * self.width + column;
                let (near, ids) = (&mut self.near[at], &mut self.id[at]);
                #[expect(clippy::needless_bitwise_bool, reason = "all samples at once")]
                for k in 0..SAMPLES {
                    let inside = (middle[0] + edge_steps[0][k] >= 0.0)
                        & (middle[1] + edge_steps[1][k] >= 0.0)
                        & (middle[2] + edge_steps[2][k] >= 0.0);
                    let z = (near_middle + near_steps[k]).max(farthest).min(nearest);
                    let wins = inside & (z > near[k]);
                    near[k] = if wins { z } else { near[k] };
                    ids[k] = if wins { id } else { ids[k] };
                }
            }
        }
        rows.len() * columns.len()
    }

    fn draw_ball(&mut self, ball: &Ball, scene: &Scene, id: u32, focal: f32) {
        self.cover(ball, scene, focal, |tile, at, k, z| {
            if z > tile.near[at][k] {
                tile.near[at][k] = z;
                tile.id[at][k] = id;
            }
        });
    }

    /// What shows of a ball through the surfaces that hide it.
    fn draw_ghost(&mut self, ball: &Ball, scene: &Scene, number: u32, focal: f32) {
        if ball.through <= 0.0 {
            return;
        }
        let id = scene.ghost_of_ball(number);
        self.cover(ball, scene, focal, |tile, at, k, z| {
            if z < tile.near[at][k] {
                tile.ghost(scene, at, k, z, id);
            }
        });
    }

    /// Ink of what is hidden, which only triangles let through.
    fn ghost(&mut self, scene: &Scene, at: usize, sample: usize, near: f32, id: u32) {
        if (self.id[at][sample] as usize) < scene.triangles.len() {
            self.stroke[at][sample].add(Ink { id, near }, near, scene);
        }
    }

    /// Calls `draw` with pixel, sample and one over the depth where a ball is seen if nothing hides it.
    fn cover(
        &mut self,
        ball: &Ball,
        scene: &Scene,
        focal: f32,
        mut draw: impl FnMut(&mut Self, usize, usize, f32),
    ) {
        let [x, y, near] = scene.screen[ball.point as usize];
        let r = f64::from(ball.radius);
        // In camera space; the radius in pixels is the same at any depth.
        let depth = 1.0 / near as f32;
        let bulge = ball.radius * depth / focal;
        for row in Self::clip(y - r, y + r, self.top, self.height) {
            for column in Self::clip(x - r, x + r, self.left, self.width) {
                let dx = ((self.left + column) as f64 + 0.5 - x) as f32;
                let dy = ((self.top + row) as f64 + 0.5 - y) as f32;
                let at = row * self.width + column;
                for (k, [ox, oy]) in OFFSETS.into_iter().enumerate() {
                    let (u, v) = ((dx + ox) / ball.radius, (dy + oy) / ball.radius);
                    let rest = 1.0 - u * u - v * v;
                    if rest < 0.0 {
                        continue;
                    }
                    let z = 1.0 / (depth - bulge * rest.sqrt()).max(0.5 * depth);
                    draw(self, at, k, z);
                }
            }
        }
    }

    /// The pixel of the tile at a place of the picture.
    fn pixel_at(&self, x: f64, y: f64) -> Option<usize> {
        let (column, row) = ((x - self.left as f64).floor(), (y - self.top as f64).floor());
        let inside =
            column >= 0.0 && row >= 0.0 && column < self.width as f64 && row < self.height as f64;
        #[expect(clippy::cast_sign_loss, reason = "inside")]
        inside.then_some(row as usize * self.width + column as usize)
    }

    /// Whether what is seen at a sample hides the stroke, which is at the depth `1 / near` there.
    fn hides(
        &self,
        at: usize,
        sample: usize,
        stroke: &Stroke,
        near: f32,
        scene: &Scene,
        slope: &mut Slope,
    ) -> bool {
        let (surface, seen) = (self.near[at][sample], self.id[at][sample]);
        let pixel = near / slope.focal;
        let raised = near + 1.5 * pixel;
        if raised >= surface {
            return false;
        }
        let at_edge = scene.triangles.get(seen as usize);
        if at_edge.is_some_and(|t| stroke.faces.contains(&t.face)) {
            return false;
        }
        let beside = slope.of(seen, scene) * (stroke.reach + 0.5);
        raised + beside.min(3.0 * pixel) < surface
    }

    /// A stroke is hidden by what is nearer, except by the faces at its edge: where one of these is
    /// seen beside the edge, so is the edge, however steep the face.
    fn draw_stroke(&mut self, stroke: &Stroke, id: u32, scene: &Scene, focal: f32) {
        let [a, b] = stroke.ends.map(|p| scene.screen[p as usize]);
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        let square = (dx * dx + dy * dy).max(1e-12);
        let reach = f64::from(stroke.reach);
        let rows =
            Self::clip(a[1].min(b[1]) - reach, a[1].max(b[1]) + reach, self.top, self.height);
        let mut slope = Slope { triangle: NONE, per_pixel: 0.0, focal };
        let mut core = (None, true);
        for row in rows {
            let top = (self.top + row) as f64;
            // The part of the stroke that reaches this row.
            let (s, t) = if dy == 0.0 {
                (0.0, 1.0)
            } else {
                let at = |y: f64| ((y - a[1]) / dy).clamp(0.0, 1.0);
                (at(top - reach), at(top + 1.0 + reach))
            };
            let (p, q) = (a[0] + s * dx, a[0] + t * dx);
            let columns = Self::clip(p.min(q) - reach, p.max(q) + reach, self.left, self.width);
            for column in columns {
                let at = row * self.width + column;
                let x = (self.left + column) as f64 + 0.5 - a[0];
                let y = top + 0.5 - a[1];
                for (k, offset) in OFFSETS.into_iter().enumerate() {
                    let [ox, oy] = offset.map(f64::from);
                    let (x, y) = (x + ox, y + oy);
                    let t = ((x * dx + y * dy) / square).clamp(0.0, 1.0);
                    let (ex, ey) = (x - t * dx, y - t * dy);
                    if ex * ex + ey * ey > reach * reach {
                        continue;
                    }
                    let near = (a[2] + t * (b[2] - a[2])) as f32;
                    let raised = near * (1.0 + 1.5 / focal);
                    // Where the line itself is hidden its width must not stick out.
                    let middle = self.pixel_at(a[0] + t * dx, a[1] + t * dy);
                    if middle != core.0 {
                        core.0 = middle;
                        core.1 = middle.is_none_or(|at| {
                            (0..SAMPLES)
                                .any(|k| !self.hides(at, k, stroke, near, scene, &mut slope))
                        });
                    }
                    if core.1 && !self.hides(at, k, stroke, near, scene, &mut slope) {
                        self.stroke[at][k].add(Ink { id, near }, raised, scene);
                    } else if stroke.through > 0.0 {
                        self.ghost(scene, at, k, near, scene.ghost_of_stroke(id));
                    }
                }
            }
        }
    }
}

/// How steep the triangle is that was asked for last.
struct Slope {
    triangle: u32,
    /// Change of one over the depth.
    per_pixel: f32,
    focal: f32,
}

impl Slope {
    fn of(&mut self, triangle: u32, scene: &Scene) -> f32 {
        if self.triangle != triangle {
            let is_triangle = (triangle as usize) < scene.triangles.len();
            let setup = is_triangle.then(|| Setup::new(scene, triangle as usize)).flatten();
            let slope = setup.map_or([0.0; 3], |setup| setup.depth_plane());
            self.triangle = triangle;
            self.per_pixel = (slope[0].abs() + slope[1].abs()) as f32;
        }
        self.per_pixel
    }
}

/// The samples that a translucent triangle covers: as many of sixteen as its opacity says, others
/// for each body and side, so that what is behind shows through.
fn covered_samples(scene: &Scene, triangle: usize, setup: &Setup) -> u16 {
    let t = &scene.triangles[triangle];
    let material = &scene.materials[t.body as usize];
    let opacity = if material.has_colours {
        t.corners.iter().map(|&c| scene.colours[c as usize][3]).sum::<f32>() / 3.0
    } else {
        material.front[3]
    };
    let count = (opacity * SAMPLES as f32).round();
    let shift = t.body * 5 + if setup.front { 0 } else { 8 };
    (0..SAMPLES as u32)
        .filter(|k| (((k + shift) * 7) % SAMPLES as u32) as f32 + 0.5 < count)
        .fold(0, |bits, k| bits | 1 << k)
}
