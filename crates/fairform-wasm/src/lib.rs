//! What the studio's page asks of the kernel, as `studio/src/kernel/api.ts` has it: a [`MeshSession`]
//! for the interpolation of a mesh, a [`StreamSession`] for a streamline model. Plain Rust, so that it is
//! tested like any other; `bindings.rs` hands it to JavaScript.
//!
//! Arrays are single precision, as the screen takes them; what is computed from them is not.

mod attributes;
#[cfg(target_arch = "wasm32")]
mod bindings;
mod drag;
mod drawing;
mod mesh_session;
mod problem;
mod stream_session;
mod values;

pub use drag::{DragAnswer, Released};
pub use drawing::Geometry;
pub use mesh_session::{FitResult, Given, Group, MeshInfo, MeshSession, Progress, Query, What};
pub use problem::{Problem, Repair};
pub use stream_session::{
    ModelChange, PatchGeometry, PatchInfo, StreamSession, edit, rotate, set_component,
};
pub use values::{Colouring, Values};
