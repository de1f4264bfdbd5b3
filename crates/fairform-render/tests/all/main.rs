//! The tests of the pictures: one program, since each would hold its own copy of the kernel.

mod marks;
mod picture;
mod plot;
mod streamlines;
mod values;
