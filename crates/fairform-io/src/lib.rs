//! Polygon meshes from bytes and to bytes: OBJ, OFF, PLY, STL, glTF and GLB, also gzipped; and
//! [models](streamline) of streamline surfaces.
//!
//! The readers take any bytes and give a [`MeshData`] or a [`ParseError`] that names the place.
//! They promise nothing about the faces except that every corner is a vertex of the mesh: faces
//! with two corners, edges with three faces and coordinates that are not finite all come through,
//! for the kernel to name and for repair to mend. Polygons stay whole.
//!
//! A count in a header is compared with the bytes that are left before anything is allocated for
//! it, so that the memory a reader takes is bounded by a multiple of the size of its input.
//!
//! With the feature `parallel` long files are read in parts and written in blocks of rows on all
//! threads of the current rayon pool. The mesh, its notes, the error and the bytes are the same with
//! any number of threads and without the feature.
//!
//! Meshes that do not fit into memory are written while they are made, see [`Blocks`].
//!
//! ```
//! use fairform_io::{Format, WriteOptions, encode, parse};
//!
//! let square = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
//! let data = parse(square, Format::Obj)?;
//! assert_eq!((data.positions.len(), data.faces.len()), (4, 1));
//!
//! let mut out = Vec::new();
//! let notes = encode(Format::Off, &data, &WriteOptions::default(), &mut out)?;
//! assert!(notes.is_empty(), "OFF holds all of it");
//! assert!(out.ends_with(b"4 0 1 2 3\n"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod crease;
mod data;
mod error;
mod fields;
#[cfg(feature = "files")]
mod file;
mod format;
mod gltf;
mod gzip;
mod lines;
mod obj;
mod off;
mod par;
mod ply;
pub mod project;
pub mod repair;
mod stl;
mod stream;
pub mod streamline;
mod text;
mod triangulate;
mod weld;

pub use crease::{CreaseList, InterpolateBoundary, parse_creases};
pub use data::{Labels, MeshData, WriteOptions};
pub use error::{Error, ParseError, Place};
pub use fields::{Fields, points_of_uvs, uvs_of_points};
#[cfg(feature = "files")]
pub use file::{discard_pending, discard_pending_then, read, save, write, write_blocks};
#[doc(hidden)]
pub use format::parse_in_parts;
pub use format::{Format, encode, parse};
pub use gltf::parse_with_buffers;
pub use gzip::limit as gzip_limit;
pub use stream::{Attributes, Blocks, Patch, Shape, can_stream, encode_blocks};
pub use triangulate::triangles;
