//! The tests of the kernel: one program, since each would hold its own copy of the kernel.

mod adaptive;
mod common;
mod edit;
mod evaluate;
mod exact;
mod fair;
mod fairness;
mod fitting;
mod golden;
mod interpolating;
mod masks;
mod onepass;
mod patches;
mod polygon_schemes;
mod refinement;
mod repair;
mod select;
mod sphere;
mod streamline;
mod streamline_models;
mod tension;
mod tessellate;
mod tessellate_blocks;
mod topology;
