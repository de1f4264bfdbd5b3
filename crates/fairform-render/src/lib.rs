//! Pictures of meshes and plots of numbers, without a window and without a GPU.
//!
//! ```
//! use fairform::{Faces, Vec3};
//! use fairform_render::{Body, Options, Panel, View, render};
//!
//! let positions = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.]].map(Vec3::from);
//! let faces: Faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]].into_iter().collect();
//! let panel = Panel { bodies: vec![Body::new(&positions, &faces)], title: Some("tetra".into()) };
//! let picture = render(&[panel], &View::default(), (160, 120), &Options::default())?;
//! assert!(picture.to_png().starts_with(b"\x89PNG"));
//! # Ok::<(), fairform_render::RenderError>(())
//! ```
//!
//! A surface is coloured by numbers with [`Values`], and shown as a mirror with [`Surface`]. Streamline
//! models are seen with [`ModelView`], their directions on the Gaussian sphere with [`SphereView`]; both
//! make [`Part`]s, bodies that own what they are made of.
//!
//! [`render`] is one straight line: the bodies of a panel become triangles, strokes and dots in
//! camera space (`scene`), lamps all around see how far their light gets (`light`), tiles of the
//! picture find what is nearest at sixteen places of every pixel (`raster`) and colour it (`shade`).
//! The same input gives the same bytes on any number of threads.

mod arrow;
mod camera;
mod canvas;
mod colour;
mod colour_map;
mod error;
mod layout;
mod legend;
mod light;
mod model_view;
mod paint;
mod par;
mod part;
mod picture;
mod plot;
mod polygon;
mod raster;
mod render;
mod scene;
mod shade;
mod sphere_view;
mod surface;
mod text;
mod ticks;
mod values;
mod view;

pub use arrow::{Arrow, Extent, Head, ParseHeadError};
pub use colour::{Colour, ParseColourError};
pub use colour_map::{ColourMap, ParseColourMapError};
pub use error::RenderError;
pub use model_view::{ModelView, ParseShowError, Show};
pub use part::Part;
pub use picture::Picture;
pub use plot::{Series, plot_svg};
pub use render::{MAX_PIXELS, MAX_SIDE, Options, render};
pub use scene::{Body, Dot, Line, Panel, Style};
pub use sphere_view::{Directions, SphereView};
pub use surface::{ParseSurfaceError, Surface};
pub use values::{ParseRangeError, Per, Range, Values};
pub use view::{Axis, ParseViewError, View};
