//! [`Faces`]: polygons as lists of vertex numbers, unchecked.

use alloc::borrow::Cow;
use alloc::vec::Vec;
use core::ops::Range;

use crate::ids::FaceId;

/// Polygons as lists of vertex numbers: what a file holds, before anything is promised about it.
///
/// Any corner count is allowed, also 0, and any vertex number, also one out of range:
/// `Topology::from_faces` names what is wrong, `repair` mends it.
#[derive(Clone, Debug)]
pub struct Faces {
    starts: Starts,
    corners: Vec<u32>,
}

/// Where faces begin. Large meshes mostly have faces of one size, which need no list.
#[derive(Clone, Debug)]
enum Starts {
    /// Every so many corners, which are some.
    Every(u32),
    /// As listed, and the end.
    Listed(Vec<u32>),
}

impl Default for Faces {
    fn default() -> Self {
        Self::new()
    }
}

/// The same faces are equal, however they were made.
impl PartialEq for Faces {
    fn eq(&self, other: &Self) -> bool {
        let same = |f| self.range(FaceId(f as u32)) == other.range(FaceId(f as u32));
        self.corners == other.corners && self.len() == other.len() && (0..self.len()).all(same)
    }
}

impl Eq for Faces {}

impl Faces {
    /// No faces.
    #[must_use]
    pub fn new() -> Self {
        Self { starts: Starts::Listed(alloc::vec![0]), corners: Vec::new() }
    }

    /// No faces yet, with room for so many.
    #[must_use]
    pub fn with_capacity(faces: usize, corners: usize) -> Self {
        let mut starts = Vec::with_capacity(faces + 1);
        starts.push(0);
        Self { starts: Starts::Listed(starts), corners: Vec::with_capacity(corners) }
    }

    /// Faces of `size` corners each.
    ///
    /// # Panics
    /// If `size` is zero, does not divide the number of corners, or there are 2³² or more corners.
    #[must_use]
    pub fn uniform(size: u32, corners: Vec<u32>) -> Self {
        assert!(size > 0 && corners.len().is_multiple_of(size as usize), "whole faces of {size}");
        assert!(u32::try_from(corners.len()).is_ok(), "fewer than 2^32 corners");
        Self { starts: Starts::Every(size), corners }
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
        let starts = match uniform_size(&start) {
            Some(size) if size > 0 => Starts::Every(size),
            _ => Starts::Listed(start),
        };
        Self { starts, corners }
    }

    /// Appends a face.
    ///
    /// # Panics
    /// If the corners of all faces are 2³² or more.
    pub fn push(&mut self, corners: &[u32]) {
        self.corners.extend_from_slice(corners);
        let end = u32::try_from(self.corners.len()).expect("fewer than 2^32 corners");
        match &mut self.starts {
            Starts::Listed(starts) => starts.push(end),
            Starts::Every(size) if corners.len() == *size as usize => {}
            Starts::Every(size) => {
                let before = end - corners.len() as u32;
                let starts = (0..=before).step_by(*size as usize).chain([end]).collect();
                self.starts = Starts::Listed(starts);
            }
        }
    }

    /// Number of faces.
    #[must_use]
    pub fn len(&self) -> usize {
        match &self.starts {
            Starts::Every(size) => self.corners.len() / *size as usize,
            Starts::Listed(starts) => starts.len() - 1,
        }
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
        &self.corners[self.range(face)]
    }

    /// Where the vertices of a face are in [`corners`](Self::corners).
    ///
    /// # Panics
    /// If there is no such face, and they are not all of one size.
    #[must_use]
    pub fn range(&self, face: FaceId) -> Range<usize> {
        let f = face.index();
        match &self.starts {
            Starts::Every(size) => {
                let size = *size as usize;
                f * size..(f + 1) * size
            }
            Starts::Listed(starts) => starts[f] as usize..starts[f + 1] as usize,
        }
    }

    /// The faces in order.
    #[must_use]
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &[u32]> + Clone {
        (0..self.len()).map(|f| self.get(FaceId(f as u32)))
    }

    /// The vertices of all faces, one face after the other.
    #[must_use]
    pub fn corners(&self) -> &[u32] {
        &self.corners
    }

    /// Where each face begins in [`corners`](Self::corners), and the end: one more than faces.
    #[must_use]
    pub fn starts(&self) -> Cow<'_, [u32]> {
        match &self.starts {
            Starts::Every(size) => {
                (0..=self.corners.len() as u32).step_by(*size as usize).collect::<Vec<_>>().into()
            }
            Starts::Listed(starts) => starts.into(),
        }
    }

    /// The number of corners that all faces have, if it is the same; `None` without faces.
    #[must_use]
    pub fn uniform_size(&self) -> Option<u32> {
        match &self.starts {
            Starts::Every(size) => (!self.corners.is_empty()).then_some(*size),
            Starts::Listed(starts) => uniform_size(starts),
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_are_the_same_however_they_were_made() {
        let corners = alloc::vec![0, 1, 2, 2, 1, 3];
        let uniform = Faces::uniform(3, corners.clone());
        let listed: Faces = [[0, 1, 2], [2, 1, 3]].into_iter().collect();
        for faces in [&listed, &Faces::from_starts(alloc::vec![0, 3, 6], corners)] {
            assert_eq!(&uniform, faces);
            assert_eq!(faces.uniform_size(), Some(3));
            assert_eq!(&*faces.starts(), [0, 3, 6]);
        }
        assert_eq!(&*uniform.starts(), [0, 3, 6]);
        assert_ne!(uniform, Faces::uniform(2, uniform.corners().to_vec()));
    }

    #[test]
    fn a_face_of_another_size_may_follow() {
        for more in [&[4, 5, 6][..], &[4, 5], &[], &[4, 5, 6, 7]] {
            let mut uniform = Faces::uniform(3, alloc::vec![0, 1, 2, 2, 1, 3]);
            let mut listed: Faces = uniform.iter().collect();
            uniform.push(more);
            listed.push(more);
            assert_eq!(uniform, listed);
            assert_eq!((uniform.len(), uniform.get(FaceId(2))), (3, more));
        }
    }

    #[test]
    fn there_may_be_none() {
        let none = Faces::uniform(3, Vec::new());
        assert_eq!(none, Faces::new());
        assert_eq!((none.len(), none.uniform_size(), none.iter().len()), (0, None, 0));
        assert_eq!(&*none.starts(), [0]);
    }
}
