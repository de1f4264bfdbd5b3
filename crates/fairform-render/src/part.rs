//! [`Part`]: a body that owns what it is made of.

use fairform::{Faces, Vec3};

use crate::{Arrow, Body, Line, Style};

/// A body that owns what it is made of; the views of models consist of such.
#[derive(Clone, Debug)]
pub struct Part {
    /// Position of each vertex.
    pub positions: Vec<Vec3>,
    /// Polygons.
    pub faces: Faces,
    /// Normal of each vertex; where zero, that of the faces.
    pub normals: Option<Vec<Vec3>>,
    /// Strokes between pairs of vertices.
    pub strokes: Vec<([u32; 2], Line)>,
    /// Directions at places.
    pub arrows: Vec<Arrow>,
    /// How it looks.
    pub style: Style,
}

impl Default for Part {
    fn default() -> Self {
        Self {
            positions: Vec::new(),
            faces: Faces::uniform(3, Vec::new()),
            normals: None,
            strokes: Vec::new(),
            arrows: Vec::new(),
            style: Style::default(),
        }
    }
}

impl Part {
    /// What [`render`](crate::render()) takes.
    #[must_use]
    pub fn body(&self) -> Body<'_> {
        Body {
            normals: self.normals.as_deref(),
            strokes: &self.strokes,
            arrows: &self.arrows,
            style: self.style,
            ..Body::new(&self.positions, &self.faces)
        }
    }

    /// Adds a line through points, in order.
    pub fn polyline(&mut self, points: impl IntoIterator<Item = Vec3>, line: Line) {
        let first = self.positions.len();
        self.positions.extend(points);
        let ends = (first + 1..self.positions.len()).map(|i| [i as u32 - 1, i as u32]);
        self.strokes.extend(ends.map(|ends| (ends, line)));
    }
}
