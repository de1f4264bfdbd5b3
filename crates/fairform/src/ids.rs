//! Typed indices. All are `u32`: half the memory of `usize`, and the same on the GPU and in
//! WebAssembly.

use core::fmt;

/// Index value that means "none", for example the twin of a boundary half-edge.
pub const NONE: u32 = u32::MAX;

macro_rules! id {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
        #[derive(bytemuck::Pod, bytemuck::Zeroable)]
        #[repr(transparent)]
        pub struct $name(pub u32);

        impl $name {
            /// The id as an index into a slice.
            #[must_use]
            pub const fn index(self) -> usize {
                self.0 as usize
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                self.0.fmt(f)
            }
        }
    };
}

id!(
    /// A vertex, numbered as in the input.
    VertexId
);
id!(
    /// A half-edge, which is the same thing as a face corner: numbered face by face, corner by
    /// corner. Half-edge `h` runs from its corner's vertex to the next one of the face.
    HalfedgeId
);
id!(
    /// An undirected edge, numbered by first appearance when the faces are walked in order.
    EdgeId
);
id!(
    /// A face, numbered as in the input.
    FaceId
);
