//! The sessions behind the studio's page.

mod common;
mod drags;
mod meshes;
mod models;
