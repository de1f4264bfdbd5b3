//! [`Faces`]: polygons as lists of vertex numbers, unchecked.

use alloc::vec::Vec;

use crate::ids::FaceId;

/// Polygons as lists of vertex numbers: what a file holds, before anything is promised about it.
///
/// Any corner count is allowed, also 0, and any vertex number, also one out of range:
/// `Topology::from_faces` names what is wrong, `repair` mends it.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Faces {
    start: Vec<u32>,
    corners: Vec<u32>,
}

impl Default for Faces {
    fn default() -> Self {
        Self::new()
    }
}

impl Faces {
    /// No faces.
    #[must_use]
    pub fn new() -> Self {
        Self { start: alloc::vec![0], corners: Vec::new() }
    }

    /// No faces yet, with room for so many.
    #[must_use]
    pub fn with_capacity(faces: usize, corners: usize) -> Self {
        let mut start = Vec::with_capacity(faces + 1);
        start.push(0);
        Self { start, corners: Vec::with_capacity(corners) }
    }

    /// Faces of `size` corners each.
    ///
    /// # Panics
    /// If `size` is zero, does not divide the number of corners, or there are 2³² or more corners.
    #[must_use]
    pub fn uniform(size: u32, corners: Vec<u32>) -> Self {
        assert!(size > 0 && corners.len().is_multiple_of(size as usize), "whole faces of {size}");
        let end = u32::try_from(corners.len()).expect("fewer than 2^32 corners");
        Self { start: (0..=end).step_by(size as usize).collect(), corners }
    }

    /// Faces from where each begins in `corners`, and the end, as [`starts`](Self::starts) gives them.
    ///
    /// ```
    /// use fairform::Faces;
    ///
    /// let faces = Faces::from_starts(vec![0, 3, 3, 7], vec![0, 1, 2, 3, 2, 1, 4]);
    /// assert_eq!(faces, [&[0, 1, 2][..], &[], &[3, 2, 1, 4]].into_iter().collect());
    /// ```
    ///
    /// # Panics
    /// If `start` does not rise from zero to the number of corners.
    #[must_use]
    pub fn from_starts(start: Vec<u32>, corners: Vec<u32>) -> Self {
        let ends = (start.first().copied(), start.last().map(|end| *end as usize));
        let rises = start.is_sorted();
        assert!(
            rises && ends == (Some(0), Some(corners.len())),
            "starts from 0 to the corner count"
        );
        Self { start, corners }
    }

    /// Appends a face.
    ///
    /// # Panics
    /// If the corners of all faces are 2³² or more.
    pub fn push(&mut self, corners: &[u32]) {
        self.corners.extend_from_slice(corners);
        self.start.push(u32::try_from(self.corners.len()).expect("fewer than 2^32 corners"));
    }

    /// Number of faces.
    #[must_use]
    pub fn len(&self) -> usize {
        self.start.len() - 1
    }

    /// Whether there is no face.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The vertices of a face, in order.
    ///
    /// # Panics
    /// If there is no such face.
    #[must_use]
    pub fn get(&self, face: FaceId) -> &[u32] {
        let f = face.index();
        &self.corners[self.start[f] as usize..self.start[f + 1] as usize]
    }

    /// The faces in order.
    #[must_use]
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &[u32]> + Clone {
        self.start.windows(2).map(|w| &self.corners[w[0] as usize..w[1] as usize])
    }

    /// The vertices of all faces, one face after the other.
    #[must_use]
    pub fn corners(&self) -> &[u32] {
        &self.corners
    }

    /// Where each face begins in [`corners`](Self::corners), and the end: one more than faces.
    #[must_use]
    pub fn starts(&self) -> &[u32] {
        &self.start
    }

    /// The number of corners that all faces have, if it is the same; `None` without faces.
    #[must_use]
    pub fn uniform_size(&self) -> Option<u32> {
        uniform_size(&self.start)
    }
}

/// The size of all faces that begin at such places, if it is the same.
pub(crate) fn uniform_size(start: &[u32]) -> Option<u32> {
    let mut sizes = start.windows(2).map(|w| w[1] - w[0]);
    let first = sizes.next()?;
    sizes.all(|s| s == first).then_some(first)
}

impl<F: AsRef<[u32]>> FromIterator<F> for Faces {
    fn from_iter<I: IntoIterator<Item = F>>(iter: I) -> Self {
        let mut faces = Self::new();
        for face in iter {
            faces.push(face.as_ref());
        }
        faces
    }
}
