//! Smooth subdivision surfaces through exactly the points you give.
#![no_std]

extern crate alloc;

pub mod faces;
pub mod ids;
pub mod repair;
pub mod vec3;

pub use faces::Faces;
pub use ids::{EdgeId, FaceId, HalfedgeId, NONE, VertexId};
pub use vec3::Vec3;
