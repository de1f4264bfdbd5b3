//! Lamps all around a scene, how far the light of each gets, and the shadow on the ground.
//!
//! All light is a sum of distant lamps: a bright one that is a small disc (the key), a few that are
//! wide (fill and rim), and the sky, evenly spread over the sphere. Each has a depth map of the
//! scene. \[Williams1978\] So one sum gives soft shadows, ambient occlusion and the contact shadow
//! on the ground, without noise.

use fairform::Vec3;

use crate::par;
use crate::scene::{Scene, Vec3f, to_f32};

pub(crate) fn dot(a: Vec3f, b: Vec3f) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn unit(a: Vec3f) -> Option<Vec3f> {
    let length = dot(a, a).sqrt();
    (length > 1e-12 && length.is_finite()).then(|| a.map(|x| x / length))
}

/// A lamp far away.
struct Lamp {
    /// Towards the lamp, in camera space, of length one.
    towards: Vec3f,
    /// Light on a surface that faces the lamp.
    light: Vec3f,
    is_key: bool,
}

pub(crate) struct Lights {
    lamps: Vec<Lamp>,
    /// One per lamp, or none if light goes through everything.
    maps: Vec<Map>,
    pub(crate) key: Vec3f,
    ground: Option<Ground>,
}

/// What arrives at a place of a surface.
#[derive(Clone, Copy)]
pub(crate) struct Arrival {
    pub(crate) light: Vec3f,
    /// Share of the key lamp that gets there.
    pub(crate) key: f32,
}

const SKY: usize = 110;
const KEY: usize = 12;
const FILL: usize = 4;
const RIM: usize = 4;

impl Lights {
    /// Lamps for a scene in which `up` is up. With `shadows` the scene is in the way of the light,
    /// with `ground` it stands on a plane that catches its shadow.
    pub(crate) fn new(scene: &Scene, up: Vec3, shadows: bool, ground: bool) -> Self {
        let up = to_f32(up);
        let lamps = lamps(up);
        let casters = casters(scene);
        let maps = if (shadows || ground) && !casters.is_empty() {
            par::map(lamps.len(), |i| Map::new(scene, &casters, &lamps[i]))
        } else {
            Vec::new()
        };
        let mut lights = Self { lamps, maps, key: to_f32(key_direction()), ground: None };
        if ground && !casters.is_empty() {
            lights.ground = Some(Ground::new(scene, &casters, up, &lights));
        }
        if !shadows {
            lights.maps = Vec::new();
        }
        lights
    }

    /// Light on the place `p` of a surface with shading normal `n`; `side` is the normal of the
    /// surface itself on the side of the eye.
    pub(crate) fn at(&self, p: Vec3f, n: Vec3f, side: Vec3f) -> Arrival {
        let mut sum = Arrival { light: [0.0; 3], key: 0.0 };
        for (i, lamp) in self.lamps.iter().enumerate() {
            let slope = dot(n, lamp.towards);
            if slope <= 0.0 {
                continue;
            }
            let seen = self.maps.get(i).map_or(1.0, |map| map.seen(p, side));
            for (sum, light) in sum.light.iter_mut().zip(lamp.light) {
                *sum += seen * slope * light;
            }
            if lamp.is_key {
                sum.key += seen / KEY as f32;
            }
        }
        sum
    }

    /// How dark, from 0 to 1, the ground is where a ray from the eye meets it.
    pub(crate) fn ground_shadow(&self, ray: Vec3) -> f32 {
        self.ground.as_ref().map_or(0.0, |ground| ground.shadow(to_f32(ray)))
    }
}

/// From the upper left, in front.
fn key_direction() -> Vec3 {
    Vec3::new(-0.55, 0.75, -0.72).normalized()
}

fn lamps(up: Vec3f) -> Vec<Lamp> {
    let mut lamps = Vec::new();
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let on_circle = |i: usize| {
        let t = golden * i as f64;
        (libm::cos(t), libm::sin(t))
    };
    for i in 0..SKY {
        // A spiral of equal steps in height meets every part of the sphere alike. [Vogel1979]
        let z = 1.0 - (2 * i + 1) as f64 / SKY as f64;
        let r = (1.0 - z * z).sqrt();
        let (c, s) = on_circle(i);
        let towards = to_f32(Vec3::new(r * c, z, r * s));
        let height = 0.5 + 0.5 * dot(up, towards);
        let (low, high) = ([0.19, 0.175, 0.165], [0.38, 0.405, 0.45]);
        // A surface under an even sky gets a quarter of what its lamps give in all.
        let share = 4.0 / SKY as f32;
        let light = std::array::from_fn(|k: usize| share * (low[k] + height * (high[k] - low[k])));
        lamps.push(Lamp { towards, light, is_key: false });
    }
    let mut disc = |towards: Vec3, radius: f64, count: usize, light: Vec3f, is_key: bool| {
        let u = towards.cross(Vec3::new(0.31, 0.2, 0.93)).normalized();
        let v = towards.cross(u);
        for i in 0..count {
            let r = radius * ((i as f64 + 0.5) / count as f64).sqrt();
            let (c, s) = on_circle(i);
            let towards = to_f32((towards + r * c * u + r * s * v).normalized());
            lamps.push(Lamp { towards, light: light.map(|l| l / count as f32), is_key });
        }
    };
    disc(key_direction(), 0.16, KEY, [0.80, 0.775, 0.73], true);
    disc(Vec3::new(0.85, 0.1, -0.6).normalized(), 0.35, FILL, [0.10, 0.105, 0.115], false);
    disc(Vec3::new(0.35, 0.6, 0.9).normalized(), 0.25, RIM, [0.26, 0.27, 0.29], false);
    lamps
}

/// The triangles that stop light: those one cannot see through.
fn casters(scene: &Scene) -> Vec<[u32; 3]> {
    let opaque = |t: &&crate::scene::Triangle| {
        let material = &scene.materials[t.body as usize];
        if !material.casts {
            false
        } else if material.has_colours {
            t.corners.iter().all(|&c| scene.colours[c as usize][3] > 0.99)
        } else {
            material.front[3] > 0.99
        }
    };
    scene.triangles.iter().filter(opaque).map(|t| t.corners).collect()
}

/// Nearest depths of the scene as a lamp sees it.
struct Map {
    /// To the right, up and towards the lamp, the first two in texels.
    axes: [Vec3f; 3],
    origin: [f32; 2],
    width: usize,
    height: usize,
    /// Along the third axis, of what is nearest to the lamp.
    nearest: Vec<f32>,
    /// Side of a texel.
    texel: f32,
}

impl Map {
    const SIZE: f64 = 160.0;
    /// Texels to look at in all.
    const WORK: f64 = 3e6;
    /// Texels around the scene that nothing covers.
    const BORDER: f64 = 2.0;

    fn new(scene: &Scene, casters: &[[u32; 3]], lamp: &Lamp) -> Self {
        let towards = Vec3::from(lamp.towards.map(f64::from));
        let side =
            if towards.y.abs() < 0.7 { Vec3::new(0., 1., 0.) } else { Vec3::new(1., 0., 0.) };
        let right = side.cross(towards).normalized();
        let up = towards.cross(right);
        // Around the middle, so that single precision is enough wherever the camera is.
        let places: Vec<[f64; 3]> =
            scene.points.iter().map(|p| [p.dot(right), p.dot(up), p.dot(towards)]).collect();
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for &c in casters.iter().flatten() {
            for k in 0..2 {
                low[k] = low[k].min(places[c as usize][k]);
                high[k] = high[k].max(places[c as usize][k]);
            }
        }
        let side = (high[0] - low[0]).max(high[1] - low[1]).max(1e-9);
        let wanted = (Self::SIZE * if lamp.is_key { 3.0 } else { 1.0 }) / side;
        let extent = |t: &[u32; 3], k: usize| {
            let [a, b, c] = t.map(|c| places[c as usize][k]);
            a.max(b).max(c) - a.min(b).min(c)
        };
        let area: f64 = casters.iter().map(|t| extent(t, 0) * extent(t, 1)).sum();
        // Coarser where the scene is many large triangles, one behind the other.
        let scale = wanted.min((Self::WORK / area).sqrt()).max(16.0 / side);
        let origin = low.map(|l| l * scale - Self::BORDER);
        #[expect(clippy::cast_sign_loss, reason = "high is not below low")]
        let [width, height] =
            [0, 1].map(|k| ((high[k] - low[k]) * scale + 2.0 * Self::BORDER).ceil() as usize + 1);
        let mut map = Self {
            axes: [to_f32(scale * right), to_f32(scale * up), lamp.towards],
            origin: origin.map(|o| o as f32),
            width,
            height,
            nearest: vec![f32::NEG_INFINITY; width * height],
            texel: (1.0 / scale) as f32,
        };
        let places: Vec<[f32; 3]> = places
            .into_iter()
            .map(|[x, y, z]| {
                [(x * scale - origin[0]) as f32, (y * scale - origin[1]) as f32, z as f32]
            })
            .collect();
        for t in casters {
            map.draw(t.map(|c| places[c as usize]));
        }
        map
    }

    #[expect(clippy::cast_sign_loss, reason = "the triangle lies in the map")]
    fn draw(&mut self, [a, b, c]: [[f32; 3]; 3]) {
        // Texels whose middle may be inside.
        let first = |k: usize| (a[k].min(b[k]).min(c[k]) - 0.5).ceil().max(0.0) as usize;
        let end = |k: usize| (a[k].max(b[k]).max(c[k]) + 0.5).floor().max(0.0) as usize;
        let (columns, rows) = (first(0)..end(0).min(self.width), first(1)..end(1).min(self.height));
        if columns.is_empty() || rows.is_empty() {
            return;
        }
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        if area == 0.0 {
            return;
        }
        let (low, high) = (a[2].min(b[2]).min(c[2]), a[2].max(b[2]).max(c[2]));
        for y in rows {
            let py = y as f32 + 0.5;
            for x in columns.clone() {
                let px = x as f32 + 0.5;
                let edge = |p: [f32; 3], q: [f32; 3]| {
                    ((q[0] - p[0]) * (py - p[1]) - (q[1] - p[1]) * (px - p[0])) / area
                };
                let (u, v, w) = (edge(b, c), edge(c, a), edge(a, b));
                if u >= 0.0 && v >= 0.0 && w >= 0.0 {
                    let z = (u * a[2] + v * b[2] + w * c[2]).clamp(low, high);
                    let nearest = &mut self.nearest[y * self.width + x];
                    *nearest = nearest.max(z);
                }
            }
        }
    }

    /// Share of the light that gets to a place just off the surface on this `side`. \[Reeves1987\]
    fn seen(&self, p: Vec3f, side: Vec3f) -> f32 {
        // As far off as a texel may hide the slope of the surface.
        let off = 1.6 * self.texel;
        let q = [p[0] + off * side[0], p[1] + off * side[1], p[2] + off * side[2]];
        let x = dot(q, self.axes[0]) - self.origin[0] - 0.5;
        let y = dot(q, self.axes[1]) - self.origin[1] - 0.5;
        let z = dot(q, self.axes[2]) + 0.6 * self.texel;
        let inside =
            x >= 0.0 && y >= 0.0 && x < (self.width - 1) as f32 && y < (self.height - 1) as f32;
        if !inside {
            return 1.0;
        }
        #[expect(clippy::cast_sign_loss, reason = "inside")]
        let (i, j) = (x as usize, y as usize);
        let (s, t) = (x - i as f32, y - j as f32);
        let at = j * self.width + i;
        let lit = |k: usize| f32::from(u8::from(self.nearest[k] <= z));
        let low = lit(at) + s * (lit(at + 1) - lit(at));
        let (at, next) = (at + self.width, at + self.width + 1);
        let high = lit(at) + s * (lit(next) - lit(at));
        low + t * (high - low)
    }
}

/// A plane below the scene that shows nothing but the shadow on it.
struct Ground {
    up: Vec3f,
    /// Height of the plane along `up`; the eye is at 0.
    height: f32,
    /// In the plane, in cells.
    axes: [Vec3f; 2],
    origin: [f32; 2],
    dark: Vec<f32>,
}

impl Ground {
    const CELLS: usize = 224;
    /// Half the side of the plane; a scene is about 2 long.
    const REACH: f32 = 2.8;
    const DARKNESS: f32 = 0.62;

    fn new(scene: &Scene, casters: &[[u32; 3]], up: Vec3f, lights: &Lights) -> Self {
        let corners = || casters.iter().flatten().map(|&c| to_f32(scene.points[c as usize]));
        let height = corners().map(|p| dot(p, up)).fold(f32::INFINITY, f32::min);
        let side = if up[0].abs() < 0.7 { [1.0, 0.0, 0.0] } else { [0.0, 0.0, 1.0] };
        let cross = |a: Vec3f, b: Vec3f| {
            [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
        };
        let u = unit(cross(up, side)).unwrap_or(side);
        let v = cross(up, u);
        let middle = [u, v].map(|axis| {
            let (low, high) = corners().fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), p| {
                let x = dot(p, axis);
                (l.min(x), h.max(x))
            });
            0.5 * (low + high)
        });
        let scale = Self::CELLS as f32 / (2.0 * Self::REACH);
        let place = |i: usize, j: usize| -> Vec3f {
            let x = middle[0] - Self::REACH + (i as f32 + 0.5) / scale;
            let y = middle[1] - Self::REACH + (j as f32 + 0.5) / scale;
            std::array::from_fn(|k| x * u[k] + y * v[k] + height * up[k])
        };
        let rows = par::map(Self::CELLS, |j| {
            (0..Self::CELLS).map(|i| lights.missing(place(i, j), up)).collect::<Vec<f32>>()
        });
        let mut dark = rows.concat();
        for _ in 0..4 {
            blur(&mut dark, Self::CELLS);
        }
        for (i, dark) in dark.iter_mut().enumerate() {
            // Fades before the plane ends.
            let from_middle = |k: usize| (2 * k + 1) as f32 / Self::CELLS as f32 - 1.0;
            let (x, y) = (from_middle(i % Self::CELLS), from_middle(i / Self::CELLS));
            let rest = 1.0 - (x * x + y * y).min(1.0);
            // No trace of a shadow that nobody would see.
            *dark = (*dark * Self::DARKNESS * rest - 0.012).max(0.0);
        }
        let axes = [u, v].map(|axis| axis.map(|a| a * scale));
        let origin = middle.map(|m| (m - Self::REACH) * scale);
        Self { up, height, axes, origin, dark }
    }

    fn shadow(&self, ray: Vec3f) -> f32 {
        let slope = dot(ray, self.up);
        // The eye must be above the plane and look down on it.
        if slope >= -1e-6 || self.height >= 0.0 {
            return 0.0;
        }
        let p = ray.map(|r| r * self.height / slope);
        let x = dot(p, self.axes[0]) - self.origin[0] - 0.5;
        let y = dot(p, self.axes[1]) - self.origin[1] - 0.5;
        let end = (Self::CELLS - 1) as f32;
        if !(x >= 0.0 && y >= 0.0 && x < end && y < end) {
            return 0.0;
        }
        #[expect(clippy::cast_sign_loss, reason = "inside")]
        let (i, j) = (x as usize, y as usize);
        let (s, t) = (x - i as f32, y - j as f32);
        let at = |i: usize, j: usize| self.dark[j * Self::CELLS + i];
        let low = at(i, j) + s * (at(i + 1, j) - at(i, j));
        let high = at(i, j + 1) + s * (at(i + 1, j + 1) - at(i, j + 1));
        low + t * (high - low)
    }
}

impl Lights {
    /// Share of the light from above that does not get to a place of the ground.
    fn missing(&self, p: Vec3f, up: Vec3f) -> f32 {
        let (mut all, mut lost) = (0.0, 0.0);
        for (lamp, map) in self.lamps.iter().zip(&self.maps) {
            let slope = dot(up, lamp.towards);
            // Lamps near the horizon throw shadows out of the picture.
            if slope > 0.3 {
                let weight = slope * lamp.light[1];
                all += weight;
                lost += weight * (1.0 - map.seen(p, up));
            }
        }
        if all > 0.0 { lost / all } else { 0.0 }
    }
}

/// Blurs a square of numbers with the weights 1 4 6 4 1 in both directions.
fn blur(cells: &mut [f32], side: usize) {
    const WEIGHTS: [f32; 5] = [0.0625, 0.25, 0.375, 0.25, 0.0625];
    for step in [1, side] {
        let before = cells.to_vec();
        for (i, cell) in cells.iter_mut().enumerate() {
            let along = if step == 1 { i % side } else { i / side };
            *cell = WEIGHTS
                .iter()
                .enumerate()
                .map(|(k, w)| {
                    let shifted = (along + k).saturating_sub(2).min(side - 1);
                    w * before[i + shifted * step - along * step]
                })
                .sum();
        }
    }
}
