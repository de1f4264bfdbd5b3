//! The tests of the command: one program, since each would hold its own copy of the kernel.

mod attributes;
mod common;
mod golden;
mod meshes;
mod models;
mod options;
mod outputs;
mod polygons;
mod projects;
mod streamline;
mod studio;
