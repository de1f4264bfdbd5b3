//! [`Panel`], [`Body`] and [`Style`]: what to draw; and [`Scene`], the same in camera space.

use fairform::{FaceId, Faces, Vec3, VertexId};

use crate::arrow::{self, Arrow, Extent};
use crate::camera::Camera;
use crate::light::dot;
use crate::paint::Paint;
use crate::polygon::{self, Corner};
use crate::surface::Finish;
use crate::values::Gauge;
use crate::{Axis, Colour, ColourMap, Per, RenderError, Surface, Values};

/// Bodies drawn together, with text below.
#[derive(Clone, Debug, Default)]
pub struct Panel<'a> {
    /// What is drawn; later strokes lie on top of earlier ones at the same place.
    pub bodies: Vec<Body<'a>>,
    /// The text below, if any. What follows a line break is set smaller.
    pub title: Option<String>,
}

/// One thing to draw.
///
/// Faces of fewer than three corners are not filled; one of two corners is an edge.
#[derive(Clone, Copy, Debug)]
pub struct Body<'a> {
    /// Position of each vertex, in any unit.
    pub positions: &'a [Vec3],
    /// Polygons, counter-clockwise seen from outside.
    pub faces: &'a Faces,
    /// Normal of each vertex, of any length, for smooth shading. Where absent, zero or not finite,
    /// the mean of the face normals weighted by the angle of the corner. \[Thürmer1998\]
    pub normals: Option<&'a [Vec3]>,
    /// Normal at each face corner, in the order of [`Faces::corners`], instead of that of its vertex: where
    /// a crease parts the surface. One that is zero, not finite, or points
    /// away from its face does not count: where a surface folds over at a corner, in that point alone.
    pub corner_normals: Option<&'a [Vec3]>,
    /// sRGB colour and opacity of each vertex, used instead of the fill's, or for the points where
    /// there is no fill. A colour that is not finite is ignored.
    pub colours: Option<&'a [[f64; 4]]>,
    /// Numbers that colour the surface, instead of its colours and its fill, whose opacity stays.
    pub values: Option<Values<'a>>,
    /// Strokes between pairs of vertices, edges or not, on top of all other edges: creases, say.
    pub strokes: &'a [([u32; 2], Line)],
    /// Directions at places.
    pub arrows: &'a [Arrow],
    /// How it looks.
    pub style: Style,
}

impl<'a> Body<'a> {
    /// A smooth surface in the usual colour.
    #[must_use]
    pub fn new(positions: &'a [Vec3], faces: &'a Faces) -> Self {
        Self {
            positions,
            faces,
            normals: None,
            corner_normals: None,
            colours: None,
            values: None,
            strokes: &[],
            arrows: &[],
            style: Style::default(),
        }
    }
}

/// How a body looks.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Style {
    /// Colour of the surface; `None` draws no surface, and what is behind shows.
    pub fill: Option<Colour>,
    /// Colour of the surface seen from behind; its opacity is the fill's.
    pub back: Colour,
    /// What the surface is made of.
    pub surface: Surface,
    /// Whether normals are interpolated over the faces; otherwise each face has one shade.
    pub smooth: bool,
    /// Strength of the highlights, from 0 (chalk) to 1 (lacquer).
    pub gloss: f64,
    /// Draws the edges of the polygons.
    pub wireframe: Option<Line>,
    /// Draws the edges that have a face on one side only.
    pub boundary: Option<Line>,
    /// Draws the vertices.
    pub points: Option<Dot>,
    /// How much of the colours of surface and points shows whatever the light, from 0 to 1 (flat).
    pub glow: f64,
    /// How much of lines and points shows through the surfaces that hide them, from 0 (nothing) to 1.
    pub through: f64,
}

impl Default for Style {
    fn default() -> Self {
        Self {
            fill: Some(Colour::PORCELAIN),
            back: Colour::CLAY,
            surface: Surface::Plain,
            smooth: true,
            gloss: 0.35,
            wireframe: None,
            boundary: None,
            points: None,
            glow: 0.0,
            through: 0.0,
        }
    }
}

/// A stroke along edges.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Line {
    /// Colour and opacity.
    pub colour: Colour,
    /// Width in thousandths of the shorter side of the panel, so that a picture looks the same at
    /// any size.
    pub width: f64,
}

impl Default for Line {
    fn default() -> Self {
        Self { colour: Colour::INK, width: 1.4 }
    }
}

/// A little ball at a vertex.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Dot {
    /// Colour; its opacity is not used.
    pub colour: Colour,
    /// Radius in thousandths of the shorter side of the panel.
    pub radius: f64,
}

impl Default for Dot {
    fn default() -> Self {
        Self { colour: Colour::RED, radius: 6.0 }
    }
}

pub(crate) type Vec3f = [f32; 3];

pub(crate) fn to_f32(v: Vec3) -> Vec3f {
    [v.x as f32, v.y as f32, v.z as f32]
}

/// The bodies of a panel in camera space, in parts that can be drawn.
pub(crate) struct Scene {
    /// Camera space.
    pub(crate) points: Vec<Vec3>,
    /// Pixels and one over the depth.
    pub(crate) screen: Vec<[f64; 3]>,
    /// Per point, in camera space.
    pub(crate) normals: Vec<Vec3f>,
    /// Per point, linear light and opacity; empty if no body has colours of its own.
    pub(crate) colours: Vec<[f32; 4]>,
    /// Per point, from 0 to 1; empty if no body has values of its vertices.
    pub(crate) values: Vec<f32>,
    /// Per face.
    pub(crate) face_normals: Vec<Vec3f>,
    /// Per face, from 0 to 1; empty if no body has values of its faces.
    pub(crate) face_values: Vec<f32>,
    pub(crate) triangles: Vec<Triangle>,
    pub(crate) materials: Vec<Material>,
    pub(crate) strokes: Vec<Stroke>,
    pub(crate) balls: Vec<Ball>,
    /// Ranges of points and how much nearer, as a factor, they are drawn than they are.
    raised: Vec<(std::ops::Range<usize>, f64)>,
}

pub(crate) struct Triangle {
    pub(crate) corners: [u32; 3],
    pub(crate) face: u32,
    pub(crate) body: u32,
}

pub(crate) struct Material {
    pub(crate) front: [f32; 4],
    pub(crate) back: Vec3f,
    pub(crate) smooth: bool,
    pub(crate) gloss: f32,
    /// How much of the colour shows whatever the light.
    pub(crate) glow: f32,
    /// Whether it stops light.
    pub(crate) casts: bool,
    pub(crate) has_colours: bool,
    pub(crate) paint: Option<Paint>,
    pub(crate) finish: Finish,
}

pub(crate) struct Stroke {
    pub(crate) ends: [u32; 2],
    /// Faces on both sides, which cannot hide it.
    pub(crate) faces: [u32; 2],
    /// Half the width in pixels.
    pub(crate) reach: f32,
    pub(crate) colour: [f32; 4],
    /// How much of it shows where it is hidden.
    pub(crate) through: f32,
}

pub(crate) struct Ball {
    pub(crate) point: u32,
    /// Radius in pixels.
    pub(crate) radius: f32,
    pub(crate) colour: Vec3f,
    pub(crate) glow: f32,
    /// How much of it shows where it is hidden.
    pub(crate) through: f32,
}

/// How much nearer arrows are drawn than they are, in their lengths.
const RAISED: f64 = 0.3;

/// Points and corners that a panel may have.
const LIMIT: usize = 1 << 30;

/// Checks everything that the rest relies on.
pub(crate) fn check(panel: &Panel, index: usize) -> Result<(), RenderError> {
    let mut size = 0_usize;
    for (b, body) in panel.bodies.iter().enumerate() {
        let vertex_count = body.positions.len();
        let (of_vertices, of_faces) = match body.values {
            Some(values) if values.per == Per::Vertex => (Some(values.of.len()), None),
            values => (None, values.map(|v| v.of.len())),
        };
        let counts = [
            ("normals", body.normals.map(<[_]>::len)),
            ("colours", body.colours.map(<[_]>::len)),
            ("values", of_vertices),
        ];
        for (what, given) in counts {
            if let Some(given) = given.filter(|&given| given != vertex_count) {
                return Err(RenderError::Count {
                    panel: index,
                    body: b,
                    what,
                    given,
                    vertex_count,
                });
            }
        }
        let corner_count = body.faces.corners().len();
        let given = body.corner_normals.map(<[_]>::len);
        if let Some(given) = given.filter(|&given| given != corner_count) {
            return Err(RenderError::CornerCount { panel: index, body: b, given, corner_count });
        }
        let face_count = body.faces.len();
        if let Some(given) = of_faces.filter(|&given| given != face_count) {
            return Err(RenderError::FaceCount { panel: index, body: b, given, face_count });
        }
        // A face has at most one point in its middle, and a corner one of its own.
        size = size
            .saturating_add(given.unwrap_or(0))
            .saturating_add(vertex_count)
            .saturating_add(body.faces.corners().len())
            .saturating_add(body.faces.len())
            .saturating_add(body.strokes.len())
            .saturating_add(body.arrows.len().saturating_mul(arrow::MOST_POINTS));
        if size > LIMIT {
            return Err(RenderError::TooLarge { panel: index });
        }
        for (f, face) in body.faces.iter().enumerate() {
            for &v in face {
                let (face, vertex) = (FaceId(f as u32), VertexId(v));
                let Some(p) = body.positions.get(vertex.index()) else {
                    return Err(RenderError::NoSuchVertex {
                        panel: index,
                        body: b,
                        face,
                        vertex,
                        vertex_count,
                    });
                };
                if !p.is_finite() {
                    return Err(RenderError::NotFinite { panel: index, body: b, vertex });
                }
            }
        }
        for (stroke, &(ends, line)) in body.strokes.iter().enumerate() {
            for vertex in ends.map(VertexId) {
                let Some(p) = body.positions.get(vertex.index()) else {
                    return Err(RenderError::NoSuchEnd {
                        panel: index,
                        body: b,
                        stroke,
                        vertex,
                        vertex_count,
                    });
                };
                if !p.is_finite() {
                    return Err(RenderError::NotFinite { panel: index, body: b, vertex });
                }
            }
            check_size("the width of a stroke", line.width)?;
        }
        if body.style.points.is_some()
            && let Some(v) = body.positions.iter().position(|p| !p.is_finite())
        {
            return Err(RenderError::NotFinite {
                panel: index,
                body: b,
                vertex: VertexId(v as u32),
            });
        }
        check_arrows(body.arrows, index, b)?;
        check_style(&body.style)?;
        if let Some(values) = &body.values {
            values.check()?;
            check_size("the width of the isolines", values.isolines.map_or(1.0, |l| l.width))?;
        }
    }
    Ok(())
}

fn check_arrows(arrows: &[Arrow], panel: usize, body: usize) -> Result<(), RenderError> {
    for (arrow, a) in arrows.iter().enumerate() {
        if !(a.at.is_finite() && a.direction.is_finite()) {
            return Err(RenderError::Arrow { panel, body, arrow });
        }
        match a.length {
            Extent::Picture(length) => check_size("the length of an arrow", length)?,
            Extent::Space(length) if (0.0..=1e300).contains(&length) => {}
            Extent::Space(value) => {
                let (what, range) = ("the length of an arrow", "from 0 to 1e300");
                return Err(RenderError::Style { what, value, range });
            }
        }
    }
    Ok(())
}

fn check_style(style: &Style) -> Result<(), RenderError> {
    let sizes = [
        ("the width of the wireframe", style.wireframe.map_or(1.0, |l| l.width)),
        ("the width of the boundary", style.boundary.map_or(1.0, |l| l.width)),
        ("the radius of the points", style.points.map_or(1.0, |d| d.radius)),
    ];
    for (what, value) in sizes {
        check_size(what, value)?;
    }
    style.surface.check()?;
    let shares =
        [("gloss", style.gloss), ("glow", style.glow), ("what shows through", style.through)];
    for (what, value) in shares {
        if !(0.0..=1.0).contains(&value) {
            return Err(RenderError::Style { what, value, range: "from 0 to 1" });
        }
    }
    Ok(())
}

fn check_size(what: &'static str, value: f64) -> Result<(), RenderError> {
    if (0.0..=200.0).contains(&value) {
        return Ok(());
    }
    Err(RenderError::Style { what, value, range: "from 0 to 200" })
}

/// The positions that the camera shall see: those of faces, strokes and arrows, and all where the
/// points are drawn.
pub(crate) fn seen<'a>(panel: &'a Panel) -> impl Iterator<Item = Vec3> + Clone + 'a {
    panel.bodies.iter().flat_map(|body| {
        let all: &[Vec3] = if body.style.points.is_some() { body.positions } else { &[] };
        let corners: &[u32] = if all.is_empty() { body.faces.corners() } else { &[] };
        let ends = body.strokes.iter().flat_map(|(ends, _)| ends);
        let used = corners.iter().chain(ends).map(|&v| body.positions[v as usize]);
        let arrows = body.arrows.iter().flat_map(|arrow| {
            let tip = match arrow.length {
                Extent::Space(length) => arrow.at + length * arrow.direction.normalized(),
                Extent::Picture(_) => arrow.at,
            };
            [arrow.at, if tip.is_finite() { tip } else { arrow.at }]
        });
        all.iter().copied().chain(used).chain(arrows)
    })
}

/// Ink is numbered: strokes, then strokes and then balls that show through what hides them.
impl Scene {
    pub(crate) fn ghost_of_stroke(&self, stroke: u32) -> u32 {
        self.strokes.len() as u32 + stroke
    }

    pub(crate) fn ghost_of_ball(&self, ball: u32) -> u32 {
        2 * self.strokes.len() as u32 + ball
    }

    /// Whether a number of ink, or of no ink, is none of a stroke that is seen.
    pub(crate) fn is_ghost(&self, ink: u32) -> bool {
        ink as usize >= self.strokes.len()
    }

    /// Colour and opacity of ink.
    pub(crate) fn ink(&self, number: u32) -> Option<[f32; 4]> {
        let (number, count) = (number as usize, self.strokes.len());
        if number < count {
            return Some(self.strokes[number].colour);
        }
        if number < 2 * count {
            let stroke = &self.strokes[number - count];
            let [r, g, b, a] = stroke.colour;
            return Some([r, g, b, a * stroke.through]);
        }
        let ball = self.balls.get(number - 2 * count)?;
        let [r, g, b] = ball.colour;
        Some([r, g, b, ball.through])
    }
}

impl Scene {
    /// The parts of a panel that passed [`check`]; `gauges` are those of the bodies, `unit` is the
    /// shorter side of the panel in thousandths, in pixels.
    pub(crate) fn new(
        panel: &Panel,
        gauges: &[Option<&Gauge>],
        camera: &Camera,
        up: Axis,
        unit: f64,
    ) -> Self {
        let mut scene = Self {
            points: Vec::new(),
            screen: Vec::new(),
            normals: Vec::new(),
            colours: Vec::new(),
            values: Vec::new(),
            face_normals: Vec::new(),
            face_values: Vec::new(),
            triangles: Vec::new(),
            materials: Vec::new(),
            strokes: Vec::new(),
            balls: Vec::new(),
            raised: Vec::new(),
        };
        let has_values =
            |per: Per| panel.bodies.iter().any(|b| b.values.is_some_and(|v| v.per == per));
        let wants = Wants {
            colours: panel.bodies.iter().any(|b| b.colours.is_some()),
            values: has_values(Per::Vertex),
            face_values: has_values(Per::Face),
        };
        for (body, gauge) in panel.bodies.iter().zip(gauges) {
            let shown = body.values.zip(*gauge);
            let material = body.style.fill.map(|fill| {
                let [r, g, b, _] = body.style.back.linear();
                Material {
                    front: fill.linear(),
                    back: [r, g, b],
                    smooth: body.style.smooth,
                    gloss: body.style.gloss as f32,
                    glow: body.style.glow as f32,
                    casts: true,
                    has_colours: body.colours.is_some() && shown.is_none(),
                    paint: shown.map(|(values, gauge)| Paint::new(&values, gauge, unit)),
                    finish: Finish::new(body.style.surface, camera, up),
                }
            });
            scene.add(body, *gauge, material, camera, unit, &wants);
        }
        scene.screen = scene.points.iter().map(|&p| camera.screen(p)).collect();
        for (points, factor) in std::mem::take(&mut scene.raised) {
            scene.screen[points].iter_mut().for_each(|[_, _, near]| *near *= factor);
        }
        scene
    }

    fn add(
        &mut self,
        body: &Body,
        gauge: Option<&Gauge>,
        material: Option<Material>,
        camera: &Camera,
        unit: f64,
        wants: &Wants,
    ) {
        let style = &body.style;
        let first_point = self.points.len() as u32;
        let first_face = self.face_normals.len() as u32;
        let flat: Vec<Vec3> = body
            .positions
            .iter()
            // Vertices without a face need not be finite; nothing reads them.
            .map(|&p| if p.is_finite() { camera.normal(p) } else { Vec3::ZERO })
            .collect();
        let (face_normals, vertex_normals) = normals(body, &flat);
        self.points.extend(flat.iter().map(|&p| camera.place(p)));
        self.normals.extend(vertex_normals.iter().map(|&n| to_f32(camera.turn(n))));
        self.face_normals.extend(face_normals.iter().map(|&n| to_f32(camera.turn(n))));
        let front = style.fill.unwrap_or(Colour::PORCELAIN).linear();
        if wants.colours {
            self.colours.extend((0..flat.len()).map(|v| own_colour(body, v).unwrap_or(front)));
        }
        // NaN where a body has no values; nothing reads them.
        let value_of = |per: Per, i: usize| match (body.values, gauge) {
            (Some(values), Some(gauge)) if values.per == per => gauge.share(values.of[i]),
            _ => f32::NAN,
        };
        if wants.values {
            self.values.extend((0..flat.len()).map(|v| value_of(Per::Vertex, v)));
        }
        if wants.face_values {
            self.face_values.extend((0..body.faces.len()).map(|f| value_of(Per::Face, f)));
        }
        if let Some(material) = material {
            self.materials.push(material);
            let is_cyclic = gauge.is_some_and(|g| g.map == ColourMap::Cyclic);
            self.fill(body, first_point, first_face, wants, is_cyclic, camera);
        }
        self.stroke(body, first_point, first_face, unit);
        if let Some(dot) = style.points.filter(|d| d.radius > 0.0) {
            self.balls.extend((0..flat.len()).map(|v| {
                let own = own_colour(body, v).filter(|_| style.fill.is_none());
                let [r, g, b, _] = own.unwrap_or(dot.colour.linear());
                let radius = (dot.radius * unit) as f32;
                Ball {
                    point: first_point + v as u32,
                    radius,
                    colour: [r, g, b],
                    glow: style.glow as f32,
                    through: style.through as f32,
                }
            }));
        }
        for arrow in body.arrows {
            self.arrow(arrow, camera, unit, wants);
        }
    }

    fn arrow(&mut self, arrow: &Arrow, camera: &Camera, unit: f64, wants: &Wants) {
        let (at, direction) = (camera.normal(arrow.at), arrow.direction.normalized());
        let depth = camera.place(at).z;
        let length = match arrow.length {
            Extent::Picture(length) => length * unit * depth / camera.focal,
            Extent::Space(length) => camera.length(length),
        };
        // What reaches behind the eye cannot be drawn.
        if direction == Vec3::ZERO || !(length > 0.0 && length < 0.5 * depth) {
            return;
        }
        let solid = arrow::solid(at, direction, length, arrow.head);
        let front = arrow.colour.linear();
        let [r, g, b, _] = front;
        let glow = if arrow.shaded { 0.25 } else { 1.0 };
        let material = Material {
            front,
            back: [r, g, b],
            smooth: true,
            gloss: if arrow.shaded { 0.3 } else { 0.0 },
            glow,
            casts: false,
            has_colours: false,
            paint: None,
            finish: Finish::Plain,
        };
        let same = |m: &Material| !m.casts && m.front == front && m.glow == glow;
        if !self.materials.last().is_some_and(same) {
            self.materials.push(material);
        }
        let body = self.materials.len() as u32 - 1;
        let (first, face) = (self.points.len(), self.face_normals.len() as u32);
        self.points.extend(solid.points.iter().map(|&p| camera.place(p)));
        self.normals.extend(solid.normals.iter().map(|&n| to_f32(camera.turn(n))));
        self.face_normals.push([0.0; 3]);
        if wants.face_values {
            self.face_values.push(f32::NAN);
        }
        if wants.colours {
            self.colours.resize(self.points.len(), front);
        }
        if wants.values {
            self.values.resize(self.points.len(), f32::NAN);
        }
        let corners = |t: &[u32; 3]| t.map(|c| first as u32 + c);
        let triangles = solid.triangles.iter();
        self.triangles.extend(triangles.map(|t| Triangle { corners: corners(t), face, body }));
        self.raised.push((first..self.points.len(), 1.0 / (1.0 - RAISED * length / depth)));
    }

    /// The faces, of the last material.
    fn fill(
        &mut self,
        body: &Body,
        first_point: u32,
        first_face: u32,
        wants: &Wants,
        is_cyclic: bool,
        camera: &Camera,
    ) {
        let number = self.materials.len() as u32 - 1;
        let (mut corners, mut places): (Vec<u32>, Vec<Vec3>) = (Vec::new(), Vec::new());
        for (f, face) in body.faces.iter().enumerate().filter(|(_, face)| face.len() >= 3) {
            corners.clear();
            corners.extend(face.iter().map(|v| first_point + v));
            if let Some(normals) = body.corner_normals {
                let own = &normals[body.faces.range(FaceId(f as u32))];
                self.part(&mut corners, own, first_face as usize + f, camera);
            }
            places.clear();
            places.extend(corners.iter().map(|&c| self.points[c as usize]));
            let middle = self.points.len() as u32;
            let mut uses_middle = false;
            let triangles = &mut self.triangles;
            polygon::fill(&places, |triangle| {
                let corners = triangle.map(|c| match c {
                    Corner::At(i) => corners[i],
                    Corner::Middle => {
                        uses_middle = true;
                        middle
                    }
                });
                triangles.push(Triangle { corners, face: first_face + f as u32, body: number });
            });
            if uses_middle {
                let n = corners.len() as f32;
                self.points.push(places.iter().copied().sum::<Vec3>() / f64::from(n));
                self.normals.push(mean(corners.iter().map(|&c| self.normals[c as usize]), n));
                if wants.values {
                    let first = self.values[corners[0] as usize];
                    let all = corners.iter().map(|&c| {
                        let value = self.values[c as usize];
                        [if is_cyclic { nearest_turn(value, first) } else { value }]
                    });
                    let [own] = mean(all, n);
                    self.values.push(own);
                }
                if wants.colours {
                    let own = mean(corners.iter().map(|&c| self.colours[c as usize]), n);
                    self.colours.push(own);
                }
            }
        }
    }

    /// Gives corners whose normal is another than that of their point a point of their own.
    fn part(&mut self, corners: &mut [u32], normals: &[Vec3], face: usize, camera: &Camera) {
        let front = self.face_normals[face];
        for (corner, &normal) in corners.iter_mut().zip(normals) {
            let (point, normal) = (*corner as usize, normal.normalized());
            if !normal.is_finite() || normal == Vec3::ZERO {
                continue;
            }
            let turned = to_f32(camera.turn(normal));
            if self.normals[point] == turned || dot(turned, front) < 0.0 {
                continue;
            }
            *corner = self.points.len() as u32;
            self.points.push(self.points[point]);
            self.normals.push(turned);
            if let Some(&value) = self.values.get(point) {
                self.values.push(value);
            }
            if let Some(&colour) = self.colours.get(point) {
                self.colours.push(colour);
            }
        }
    }

    fn stroke(&mut self, body: &Body, first_point: u32, first_face: u32, unit: f64) {
        let style = &body.style;
        if style.wireframe.is_none() && style.boundary.is_none() && body.strokes.is_empty() {
            return;
        }
        let edges = edges(body.faces);
        let stroke = |ends: [u32; 2], faces: [u32; 2], line: Line| Stroke {
            ends: ends.map(|v| first_point + v),
            faces,
            reach: (0.5 * line.width * unit) as f32,
            colour: line.colour.linear(),
            through: style.through as f32,
        };
        let beside = |e: &Edge| e.faces.map(|f| first_face + f);
        let mut draw = |line: Option<Line>, only_boundary: bool| {
            let Some(line) = line.filter(|l| l.width > 0.0) else { return };
            let kept = edges.iter().filter(|e| !only_boundary || e.count == 1);
            self.strokes.extend(kept.map(|e| stroke(e.ends, beside(e), line)));
        };
        draw(style.wireframe, false);
        draw(style.boundary, true);
        for &([a, b], line) in body.strokes.iter().filter(|(_, line)| line.width > 0.0) {
            let ends = [a.min(b), a.max(b)];
            let faces = match edges.binary_search_by_key(&ends, |e| e.ends) {
                Ok(edge) => beside(&edges[edge]),
                Err(_) => [u32::MAX; 2],
            };
            self.strokes.push(stroke([a, b], faces, line));
        }
    }
}

/// Which lists of a scene are kept for all its bodies, since one needs them.
struct Wants {
    colours: bool,
    values: bool,
    face_values: bool,
}

/// The value that is the same on a circle of length 1 and nearest to another.
pub(crate) fn nearest_turn(value: f32, to: f32) -> f32 {
    value + (to - value).round()
}

fn mean<const N: usize>(all: impl Iterator<Item = [f32; N]>, count: f32) -> [f32; N] {
    let sum = all.fold([0.0; N], |sum, a| std::array::from_fn(|i| sum[i] + a[i]));
    sum.map(|s| s / count)
}

fn own_colour(body: &Body, vertex: usize) -> Option<[f32; 4]> {
    let colour = body.colours?[vertex];
    colour.iter().all(|c| c.is_finite()).then(|| Colour::from(colour).linear())
}

/// Unit normals of the faces and of the vertices; zero where there is none.
fn normals(body: &Body, positions: &[Vec3]) -> (Vec<Vec3>, Vec<Vec3>) {
    let mut of_vertices = vec![Vec3::ZERO; positions.len()];
    let mut corners: Vec<Vec3> = Vec::new();
    let of_faces = body
        .faces
        .iter()
        .map(|face| {
            corners.clear();
            corners.extend(face.iter().map(|&v| positions[v as usize]));
            let normal = polygon::area_vector(&corners).normalized();
            let n = face.len();
            for i in 0..n {
                let p = corners[i];
                let a = (corners[(i + 1) % n] - p).normalized();
                let b = (corners[(i + n - 1) % n] - p).normalized();
                let angle = libm::acos(a.dot(b).clamp(-1.0, 1.0));
                of_vertices[face[i] as usize] += angle * normal;
            }
            normal
        })
        .collect();
    for (v, normal) in of_vertices.iter_mut().enumerate() {
        let given = body.normals.map_or(Vec3::ZERO, |given| given[v]);
        *normal =
            if given.is_finite() && given != Vec3::ZERO { given } else { *normal }.normalized();
    }
    (of_faces, of_vertices)
}

struct Edge {
    ends: [u32; 2],
    /// The first two faces; the first twice if there is only one.
    faces: [u32; 2],
    count: u32,
}

/// The edges of the polygons, each once, in order of their ends.
fn edges(faces: &Faces) -> Vec<Edge> {
    let mut sides: Vec<([u32; 2], u32)> = Vec::with_capacity(faces.corners().len());
    for (f, face) in faces.iter().enumerate() {
        let n = if face.len() == 2 { 1 } else { face.len() };
        let ends = (0..n).map(|i| (face[i], face[(i + 1) % face.len()]));
        sides.extend(ends.filter(|(a, b)| a != b).map(|(a, b)| ([a.min(b), a.max(b)], f as u32)));
    }
    sides.sort_unstable();
    sides
        .chunk_by(|a, b| a.0 == b.0)
        .map(|same| {
            let count = same.len() as u32;
            Edge { ends: same[0].0, faces: [same[0].1, same[usize::from(count > 1)].1], count }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_know_their_faces() {
        let faces: Faces = [&[0, 1, 2][..], &[2, 1, 3], &[5, 4], &[7]].into_iter().collect();
        let found: Vec<_> = edges(&faces).iter().map(|e| (e.ends, e.count)).collect();
        let expected =
            [([0, 1], 1), ([0, 2], 1), ([1, 2], 2), ([1, 3], 1), ([2, 3], 1), ([4, 5], 1)];
        assert_eq!(found, expected);
    }

    /// The corner of a cube points along its diagonal also if one side is two triangles.
    #[test]
    fn normals_do_not_depend_on_diagonals() {
        let p = [
            [0., 0., 0.],
            [1., 0., 0.],
            [0., 1., 0.],
            [0., 0., 1.],
            [1., 1., 0.],
            [1., 0., 1.],
            [0., 1., 1.],
        ]
        .map(Vec3::from);
        let faces: Faces =
            [&[0, 2, 4][..], &[0, 4, 1], &[0, 1, 5, 3], &[0, 3, 6, 2]].into_iter().collect();
        let (_, normals) = normals(&Body::new(&p, &faces), &p);
        let diagonal = Vec3::splat(-1.0).normalized();
        assert!((normals[0] - diagonal).length() < 1e-15, "{:?}", normals[0]);
    }
}
