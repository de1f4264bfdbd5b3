//! Colours and texture coordinates as points, for the kernel to fit and refine as it does positions.

use fairform::Vec3;

use crate::data::MeshData;

/// What travels along with the vertices of a mesh, one `T` for each attribute.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Fields<T = Vec<Vec3>> {
    /// Red, green, blue.
    pub colours: Option<T>,
    /// Opacity in the first place, where some colour is not opaque.
    pub opacity: Option<T>,
    /// Texture coordinates in the first two places.
    pub uvs: Option<T>,
}

impl<T> Fields<T> {
    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.colours.is_none() && self.opacity.is_none() && self.uvs.is_none()
    }

    /// One after the other.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = &mut T> {
        [&mut self.colours, &mut self.opacity, &mut self.uvs].into_iter().flatten()
    }

    /// What `make` makes of each.
    pub fn map<'s, U>(&'s self, mut make: impl FnMut(&'s T) -> U) -> Fields<U> {
        let mut one = |field: &'s Option<T>| field.as_ref().map(&mut make);
        Fields { colours: one(&self.colours), opacity: one(&self.opacity), uvs: one(&self.uvs) }
    }

    /// What `make` makes of each, if it can.
    ///
    /// # Errors
    /// The first of `make`.
    pub fn try_map<'s, U, E>(
        &'s self,
        mut make: impl FnMut(&'s T) -> Result<U, E>,
    ) -> Result<Fields<U>, E> {
        let mut one = |field: &'s Option<T>| field.as_ref().map(&mut make).transpose();
        Ok(Fields {
            colours: one(&self.colours)?,
            opacity: one(&self.opacity)?,
            uvs: one(&self.uvs)?,
        })
    }
}

impl Fields {
    /// Those of a mesh, but for those that are not finite.
    #[must_use]
    pub fn of(data: &MeshData) -> Self {
        let finite = |values: &Vec<Vec3>| values.iter().all(|v| v.is_finite());
        let given = data.colours.as_ref();
        let rgb = |c: &Vec<[f64; 4]>| c.iter().map(|&[r, g, b, _]| Vec3::new(r, g, b)).collect();
        let alpha = |c: &Vec<[f64; 4]>| c.iter().map(|c| Vec3::new(c[3], 0.0, 0.0)).collect();
        let colours = given.map(rgb).filter(finite);
        let clear = given.filter(|c| colours.is_some() && c.iter().any(|c| c[3] != 1.0));
        let opacity = clear.map(alpha).filter(finite);
        let uvs = data.uvs.as_deref().map(points_of_uvs).filter(finite);
        Self { colours, opacity, uvs }
    }

    /// Gives them to a mesh. Colours that refinement took out of their range are cut off.
    pub fn put(self, data: &mut MeshData) {
        let opacity = self.opacity;
        data.colours = self.colours.map(|colours| colours_of(&colours, opacity.as_deref()));
        data.uvs = self.uvs.as_deref().map(uvs_of_points);
    }
}

/// Colours as a file has them.
fn colours_of(colours: &[Vec3], opacity: Option<&[Vec3]>) -> Vec<[f64; 4]> {
    let channel = |x: f64| x.clamp(0.0, 1.0);
    let with_opacity = |(i, c): (usize, &Vec3)| {
        let a = opacity.map_or(1.0, |o| channel(o[i].x));
        [channel(c.x), channel(c.y), channel(c.z), a]
    };
    colours.iter().enumerate().map(with_opacity).collect()
}

/// Texture coordinates as points.
#[must_use]
pub fn points_of_uvs(uvs: &[[f64; 2]]) -> Vec<Vec3> {
    uvs.iter().map(|&[u, v]| Vec3::new(u, v, 0.0)).collect()
}

/// Texture coordinates as a file has them.
#[must_use]
pub fn uvs_of_points(points: &[Vec3]) -> Vec<[f64; 2]> {
    points.iter().map(|p| [p.x, p.y]).collect()
}
