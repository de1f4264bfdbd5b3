//! [`RenderError`]: why a picture could not be made.

use fairform::{FaceId, VertexId};

/// Why a picture could not be made. Panels and bodies are counted from 0.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// The picture would be empty or larger than the limits.
    #[error(
        "a picture of {width}x{height} pixels cannot be made: sides are 1 to {max}, {pixels} pixels \
         in all at most",
        max = crate::MAX_SIDE,
        pixels = crate::MAX_PIXELS
    )]
    Size {
        /// Asked width in pixels.
        width: u32,
        /// Asked height in pixels.
        height: u32,
    },
    /// The panels do not find room in the picture.
    #[error("{panels} panels do not fit into {width}x{height} pixels")]
    NoRoom {
        /// Number of panels.
        panels: usize,
        /// Width of the picture in pixels.
        width: u32,
        /// Height of the picture in pixels.
        height: u32,
    },
    /// A number of the view is outside its range.
    #[error("the view's {what} is {value}, but must be {range}")]
    View {
        /// Which number.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        range: &'static str,
    },
    /// A number of a style or option is outside its range.
    #[error("{what} is {value}, but must be {range}")]
    Style {
        /// Which number.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        range: &'static str,
    },
    /// A face lists a vertex that its body does not have.
    #[error(
        "panel {panel}, body {body}: face {face} lists vertex {vertex}, but there are \
         {vertex_count} vertices"
    )]
    NoSuchVertex {
        /// Panel.
        panel: usize,
        /// Body in the panel.
        body: usize,
        /// Face in the body.
        face: FaceId,
        /// The vertex it lists.
        vertex: VertexId,
        /// Number of vertices of the body.
        vertex_count: usize,
    },
    /// A drawn vertex has a coordinate that is NaN or infinite.
    #[error("panel {panel}, body {body}: vertex {vertex} has a coordinate that is not finite")]
    NotFinite {
        /// Panel.
        panel: usize,
        /// Body in the panel.
        body: usize,
        /// The vertex.
        vertex: VertexId,
    },
    /// Normals, colours or values are not one per vertex.
    #[error("panel {panel}, body {body}: {given} {what} are given for {vertex_count} vertices")]
    Count {
        /// Panel.
        panel: usize,
        /// Body in the panel.
        body: usize,
        /// `"normals"`, `"colours"` or `"values"`.
        what: &'static str,
        /// How many are given.
        given: usize,
        /// Number of vertices of the body.
        vertex_count: usize,
    },
    /// Values are not one per face.
    #[error("panel {panel}, body {body}: {given} values are given for {face_count} faces")]
    FaceCount {
        /// Panel.
        panel: usize,
        /// Body in the panel.
        body: usize,
        /// How many are given.
        given: usize,
        /// Number of faces of the body.
        face_count: usize,
    },
    /// Normals are not one per face corner.
    #[error("panel {panel}, body {body}: {given} normals are given for {corner_count} corners")]
    CornerCount {
        /// Panel.
        panel: usize,
        /// Body in the panel.
        body: usize,
        /// How many are given.
        given: usize,
        /// Number of face corners of the body.
        corner_count: usize,
    },
    /// A stroke ends at a vertex that its body does not have.
    #[error(
        "panel {panel}, body {body}: stroke {stroke} ends at vertex {vertex}, but there are \
         {vertex_count} vertices"
    )]
    NoSuchEnd {
        /// Panel.
        panel: usize,
        /// Body in the panel.
        body: usize,
        /// Stroke of the body.
        stroke: usize,
        /// The vertex it ends at.
        vertex: VertexId,
        /// Number of vertices of the body.
        vertex_count: usize,
    },
    /// An arrow begins at, or points to, what is not finite.
    #[error("panel {panel}, body {body}: arrow {arrow} has a coordinate that is not finite")]
    Arrow {
        /// Panel.
        panel: usize,
        /// Body in the panel.
        body: usize,
        /// Arrow of the body.
        arrow: usize,
    },
    /// A panel holds more vertices or corners than can be numbered.
    #[error("panel {panel} holds more than 2^30 vertices and corners")]
    TooLarge {
        /// Panel.
        panel: usize,
    },
}
