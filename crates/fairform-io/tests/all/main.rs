//! The tests of the readers and writers: one program, since each would hold its own copy of the kernel.

mod any_bytes;
mod common;
mod corpus;
mod project;
mod round_trip;
mod stream;
mod streamline;
mod threads;
