//! Colours of the pixels of a [`Tile`].

use fairform::Vec3;

use crate::Per;
use crate::camera::Camera;
use crate::colour::encode;
use crate::light::{Arrival, Lights, dot, unit};
use crate::paint::Paint;
use crate::raster::{NONE, OFFSETS, SAMPLES, Setup, Tile};
use crate::scene::{Material, Scene, Triangle, Vec3f, nearest_turn, to_f32};
use crate::surface::Finish;

/// Light times opacity, and opacity.
type Premultiplied = [f32; 4];

/// What a pixel is made of besides its tile.
pub(crate) struct Shading<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) lights: &'a Lights,
    pub(crate) camera: &'a Camera,
    /// Linear light and opacity.
    pub(crate) background: [f32; 4],
    /// Of the panel in pixels.
    pub(crate) size: [f64; 2],
}

/// A place of a surface.
struct Place {
    position: Vec3f,
    /// For shading, on the side of the eye.
    normal: Vec3f,
    /// Of the surface itself, on the side of the eye.
    side: Vec3f,
    colour: Vec3f,
    gloss: f32,
    /// How much of the colour shows whatever the light, from 0 to 1: colours that are read as numbers
    /// must not be lost in shadow.
    glow: f32,
    /// What it mirrors, added to the rest.
    mirrored: f32,
}

/// Places of a pixel, and those among them where one triangle is seen.
struct Samples<'a> {
    /// Middle of the pixel.
    x: f64,
    y: f64,
    ids: &'a [u32; SAMPLES],
    id: u32,
}

impl Samples<'_> {
    fn places(&self) -> impl Iterator<Item = [f64; 2]> {
        let seen = (0..SAMPLES).filter(|&k| self.ids[k] == self.id);
        seen.map(|k| [self.x + f64::from(OFFSETS[k][0]), self.y + f64::from(OFFSETS[k][1])])
    }
}

impl Shading<'_> {
    /// The pixels of a rectangle (left, top, right, bottom) in a tile, row by row.
    pub(crate) fn pixels(
        &self,
        tile: &Tile,
        [left, top, right, bottom]: [usize; 4],
    ) -> Vec<[u8; 4]> {
        let start = |row: usize| (row - tile.top) * tile.width + left - tile.left;
        let rows = (top..bottom).map(|row| start(row)..start(row) + right - left);
        rows.flatten().map(|at| encoded(self.pixel(tile, at))).collect()
    }

    /// The mean over the samples. Each triangle is shaded once per pixel, in the middle of the
    /// samples where it is seen.
    fn pixel(&self, tile: &Tile, at: usize) -> Premultiplied {
        let x = (tile.left + at % tile.width) as f64 + 0.5;
        let y = (tile.top + at / tile.width) as f64 + 0.5;
        let ids = &tile.id[at];
        let stroke = tile.stroke.get(at).filter(|s| s.iter().any(|s| s.top.id != NONE));
        let mut colours = [[0.0; 4]; SAMPLES];
        let mut known: Option<(Vec3f, Vec3f, Arrival)> = None;
        for k in 0..SAMPLES {
            let id = ids[k];
            if ids[..k].contains(&id) {
                continue;
            }
            let colour = if id == NONE {
                self.behind(x, y)
            } else {
                let mut middle = [0.0; 2];
                let mut count = 0.0_f32;
                for j in (k..SAMPLES).filter(|&j| ids[j] == id) {
                    middle = [middle[0] + OFFSETS[j][0], middle[1] + OFFSETS[j][1]];
                    count += 1.0;
                }
                let [dx, dy] = middle.map(|m| f64::from(m / count));
                let samples = Samples { x, y, ids, id };
                match self.place(x + dx, y + dy, &samples) {
                    Some(place) => {
                        // Neighbours that lie alike are lit alike.
                        let same = known.filter(|(p, n, _)| {
                            let d: Vec3f = std::array::from_fn(|i| p[i] - place.position[i]);
                            dot(*n, place.normal) > 0.98 && dot(d, d) < 1e-3
                        });
                        let arrival = same.map_or_else(
                            || self.lights.at(place.position, place.normal, place.side),
                            |(_, _, arrival)| arrival,
                        );
                        known = Some((place.position, place.normal, arrival));
                        let [r, g, b] = self.seen(&place, arrival);
                        [r, g, b, 1.0]
                    }
                    None => self.behind(x, y),
                }
            };
            for j in k..SAMPLES {
                if ids[j] == id {
                    colours[j] = colour;
                }
            }
        }
        if let Some(stroke) = stroke {
            for (colour, ink) in colours.iter_mut().zip(stroke) {
                for ink in [ink.below, ink.top].into_iter().filter_map(|i| self.scene.ink(i.id)) {
                    *colour = over(ink, *colour);
                }
            }
        }
        let sum = colours
            .iter()
            .fold([0.0; 4], |sum: Premultiplied, c| std::array::from_fn(|i| sum[i] + c[i]));
        sum.map(|s| s / SAMPLES as f32)
    }

    /// The background with the shadow on the ground.
    fn behind(&self, x: f64, y: f64) -> Premultiplied {
        let [r, g, b, a] = self.background;
        let shadow = self.lights.ground_shadow(self.camera.ray(x, y));
        // Fades at the border of the panel, so that no border shows.
        let [width, height] = self.size;
        let free = x.min(width - x).min(y).min(height - y) / (0.12 * width.min(height));
        let free = free.clamp(0.0, 1.0) as f32;
        let ground = shadow * free * free * (3.0 - 2.0 * free);
        over([0.0, 0.0, 0.0, ground], [r * a, g * a, b * a, a])
    }

    fn place(&self, x: f64, y: f64, samples: &Samples) -> Option<Place> {
        match (samples.id as usize).checked_sub(self.scene.triangles.len()) {
            None => self.place_on_triangle(x, y, samples),
            Some(ball) => self.place_on_ball(ball, x, y),
        }
    }

    fn place_on_triangle(&self, x: f64, y: f64, samples: &Samples) -> Option<Place> {
        let scene = self.scene;
        let id = samples.id as usize;
        let setup = Setup::new(scene, id)?;
        let triangle = &scene.triangles[id];
        let material = &scene.materials[triangle.body as usize];
        let weights = setup.weights(x, y);
        let corners = triangle.corners.map(|c| c as usize);
        let position: Vec3 = (0..3).map(|i| weights[i] * scene.points[corners[i]]).sum();
        let mixed =
            |of: [&[f32]; 3], k: usize| (0..3).map(|i| weights[i] as f32 * of[i][k]).sum::<f32>();

        let [a, b, c] = corners.map(|c| scene.points[c]);
        let side = unit(to_f32((b - a).cross(c - a).normalized()))?;
        let facing = if setup.front { 1.0 } else { -1.0 };
        let position = if material.smooth {
            to_f32(position + facing * self.bulge(position, corners, weights, facing))
        } else {
            to_f32(position)
        };
        let side = if dot(side, position) > 0.0 { side.map(|s| -s) } else { side };
        let normal = if material.smooth {
            let of = corners.map(|c| &scene.normals[c][..]);
            unit(std::array::from_fn(|k| mixed(of, k)))
        } else {
            unit(scene.face_normals[triangle.face as usize])
        };
        let normal = normal.map_or(side, |n| if setup.front { n } else { n.map(|n| -n) });

        let [r, g, b, _] = material.front;
        let mut colour = [r, g, b];
        if material.has_colours {
            let of = corners.map(|c| &scene.colours[c][..]);
            colour = std::array::from_fn(|k| mixed(of, k));
        }
        if !setup.front {
            // Colours that mean something still show from behind.
            let own = if material.has_colours { 0.5 } else { 0.0 };
            colour =
                std::array::from_fn(|k| material.back[k] + own * (colour[k] - material.back[k]));
        }
        let mut place = Place {
            position,
            normal,
            side,
            colour,
            gloss: material.gloss,
            glow: material.glow,
            mirrored: 0.0,
        };
        if let Some(paint) = &material.paint {
            place.colour = self.painted(paint, triangle, &setup, samples);
            place.gloss *= 0.25;
            place.glow = place.glow.max(0.55);
        }
        if !matches!(material.finish, Finish::Plain) {
            self.finish(&mut place, material, triangle, &setup, samples);
        }
        Some(place)
    }

    /// The colour by value, over the samples.
    fn painted(
        &self,
        paint: &Paint,
        triangle: &Triangle,
        setup: &Setup,
        samples: &Samples,
    ) -> Vec3f {
        if paint.per == Per::Face {
            return paint.colour(self.scene.face_values[triangle.face as usize], 0.0);
        }
        let mut values = triangle.corners.map(|c| self.scene.values[c as usize]);
        if paint.is_cyclic {
            values = values.map(|v| nearest_turn(v, values[0]));
        }
        let value = |w: [f64; 3]| (0..3).map(|i| w[i] as f32 * values[i]).sum::<f32>();
        let change = |dx: f64, dy: f64| {
            let at = |s: f64| setup.weights_around(samples.x + s * dx, samples.y + s * dy);
            at(0.5).zip(at(-0.5)).map_or(0.0, |(to, from)| value(to) - value(from))
        };
        let slope = if paint.has_isolines() {
            let (x, y) = (change(1.0, 0.0), change(0.0, 1.0));
            (x * x + y * y).sqrt()
        } else {
            0.0
        };
        mean(samples.places().map(|[x, y]| paint.colour(value(setup.weights(x, y)), slope)))
    }

    /// What a mirror sees, over the samples, whose normals differ.
    fn finish(
        &self,
        place: &mut Place,
        material: &Material,
        triangle: &Triangle,
        setup: &Setup,
        samples: &Samples,
    ) {
        let scene = self.scene;
        let corners = triangle.corners.map(|c| c as usize);
        let facing = if setup.front { 1.0 } else { -1.0 };
        let [light] = mean(samples.places().map(|[x, y]| {
            let normal = if material.smooth {
                let weights = setup.weights(x, y).map(|w| facing * w as f32);
                unit(std::array::from_fn(|k| {
                    (0..3).map(|i| weights[i] * scene.normals[corners[i]][k]).sum::<f32>()
                }))
            } else {
                None
            };
            let ray = to_f32(self.camera.ray(x, y));
            let eye = unit(ray.map(|r| -r)).unwrap_or([0.0, 0.0, -1.0]);
            [material.finish.mirrored(normal.unwrap_or(place.normal), eye)]
        }));
        match material.finish {
            Finish::Plain => {}
            Finish::Zebra { .. } => {
                // Colours that mean something stay.
                let own = if material.paint.is_some() || material.has_colours { 1.0 } else { 0.25 };
                let share = ZEBRA_DARK + (1.0 - ZEBRA_DARK) * light;
                place.colour = place.colour.map(|c| share * (1.0 + own * (c - 1.0)));
                place.gloss = 0.0;
                place.glow = 0.55;
            }
            Finish::Reflection { .. } => {
                place.colour = place.colour.map(|c| LACQUER * c);
                place.gloss = 0.0;
                place.mirrored = 0.9 * light;
            }
        }
    }

    /// From a place of a triangle to the smooth surface that its normals pretend, so that a coarse
    /// mesh throws no facets of shadow on itself. \[Hanika2021\]
    fn bulge(&self, p: Vec3, corners: [usize; 3], weights: [f64; 3], facing: f64) -> Vec3 {
        (0..3)
            .map(|i| {
                let normal = Vec3::from(self.scene.normals[corners[i]].map(f64::from));
                let below = facing * (self.scene.points[corners[i]] - p).dot(normal);
                weights[i] * below.max(0.0) * normal
            })
            .sum()
    }

    fn place_on_ball(&self, ball: usize, x: f64, y: f64) -> Option<Place> {
        let ball = self.scene.balls.get(ball)?;
        let [cx, cy, near] = self.scene.screen[ball.point as usize];
        let u = ((x - cx) as f32) / ball.radius;
        let v = ((cy - y) as f32) / ball.radius;
        let w = (1.0 - u * u - v * v).max(0.0).sqrt();
        let normal = unit([u, v, -w])?;
        let radius = ball.radius / (near * self.camera.focal) as f32;
        let middle = to_f32(self.scene.points[ball.point as usize]);
        let position = std::array::from_fn(|k| middle[k] + radius * normal[k]);
        Some(Place {
            position,
            normal,
            side: normal,
            colour: ball.colour,
            gloss: 0.6,
            glow: ball.glow,
            mirrored: 0.0,
        })
    }

    /// Light that a place sends to the eye: diffuse, a highlight of the key lamp \[Blinn1977\], and
    /// a sheen where one looks along the surface.
    fn seen(&self, place: &Place, arrival: Arrival) -> Vec3f {
        let eye = unit(place.position.map(|p| -p)).unwrap_or([0.0, 0.0, -1.0]);
        let half = unit(std::array::from_fn(|k| eye[k] + self.lights.key[k])).unwrap_or(eye);
        let h = dot(place.normal, half).max(0.0);
        let h4 = h * h * h * h;
        let h16 = h4 * h4 * h4 * h4;
        let highlight = 0.42 * place.gloss * h16 * h16 * arrival.key;
        let grazing = 1.0 - dot(place.normal, eye).clamp(0.0, 1.0);
        let sheen = 0.35 * place.gloss * grazing * grazing * grazing;
        std::array::from_fn(|k| {
            let light = arrival.light[k] + place.glow * (1.0 - arrival.light[k]);
            (place.colour[k] + sheen) * light + highlight + place.mirrored
        })
    }
}

/// Light of a dark stripe as a share of that of a light one.
const ZEBRA_DARK: f32 = 0.025;

/// Light of a lacquer from below its surface as a share of that of a dull surface.
const LACQUER: f32 = 0.07;

fn mean<const N: usize>(all: impl Iterator<Item = [f32; N]>) -> [f32; N] {
    let (sum, count) = all.fold(([0.0; N], 0.0_f32), |(sum, count), a| {
        (std::array::from_fn(|i| sum[i] + a[i]), count + 1.0)
    });
    sum.map(|s| s / count)
}

/// A straight colour over a premultiplied one.
fn over([r, g, b, a]: [f32; 4], below: Premultiplied) -> Premultiplied {
    let rest = 1.0 - a;
    [r * a + rest * below[0], g * a + rest * below[1], b * a + rest * below[2], a + rest * below[3]]
}

fn encoded([r, g, b, a]: Premultiplied) -> [u8; 4] {
    if a <= 0.0 {
        return [0; 4];
    }
    #[expect(clippy::cast_sign_loss, reason = "clamped to 0..1")]
    let opacity = (a.clamp(0.0, 1.0) * 255.0).round() as u8;
    [encode(r / a), encode(g / a), encode(b / a), opacity]
}
