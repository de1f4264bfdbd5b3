//! [`Camera`]: from the coordinates of the input to those of the camera and to pixels.

use fairform::Vec3;

use crate::View;

/// A perspective camera that has everything in its frame.
///
/// Camera space has x to the right, y up and z *into* the picture, the eye at the origin, and the
/// longest side of what is shown is 2 long, whatever the unit of the input.
pub(crate) struct Camera {
    centre: Vec3,
    scale: f64,
    axes: [Vec3; 3],
    shift: [f64; 2],
    distance: f64,
    /// Pixels per unit at depth 1.
    pub(crate) focal: f64,
    middle: [f64; 2],
}

impl Camera {
    /// The camera that shows all `points` in a frame of `size` pixels with `margin` pixels left free
    /// on all sides; `None` without points. The points are finite.
    ///
    /// With $`t`$ the tangent of half the horizontal opening, a camera at $`(c, -d)`$ sees
    /// $`(x, z)`$ if $`|x - c| \le t\,(z + d)`$. Hence
    /// $`c = \frac{1}{2}(\max(x - t z) + \min(x + t z))`$ needs the least $`d`$, which is
    /// $`\frac{1}{2t}(\max(x - t z) - \min(x + t z))`$; likewise vertically.
    pub(crate) fn fit(
        points: impl Iterator<Item = Vec3> + Clone,
        view: &View,
        size: [f64; 2],
        margin: f64,
    ) -> Option<Self> {
        let mut box_points = points.clone();
        let first = box_points.next()?;
        let (low, high) = box_points.fold((first, first), |(l, h), p| (l.min(p), h.max(p)));
        // Halved first: the difference of huge coordinates overflows.
        let centre = 0.5 * low + 0.5 * high;
        let half = (0.5 * high - 0.5 * low).max_abs();
        let scale = if half > 0.0 { half } else { 1.0 };
        let axes = view.axes();

        let open = libm::tan(0.5 * view.field.to_radians());
        let focal = 0.5 * size[1] / open;
        let tangent = size.map(|s| (0.5 * s - margin).max(0.25 * s) / focal);
        let mut most = [f64::NEG_INFINITY; 2];
        let mut least = [f64::INFINITY; 2];
        let mut nearest = f64::INFINITY;
        for p in points {
            let [x, y, z] = turned(&axes, normal_position(p, centre, scale));
            for (i, a) in [x, y].into_iter().enumerate() {
                most[i] = most[i].max(a - tangent[i] * z);
                least[i] = least[i].min(a + tangent[i] * z);
            }
            nearest = nearest.min(z);
        }
        let shift = [0.5 * (most[0] + least[0]), 0.5 * (most[1] + least[1])];
        let needed = |i: usize| (most[i] - least[i]) / (2.0 * tangent[i]);
        // Not so near that a flat or lonely thing touches the lens.
        let distance = needed(0).max(needed(1)).max(0.3 / open.max(0.3) - nearest);
        Some(Self {
            centre,
            scale,
            axes,
            shift,
            distance,
            focal: focal * view.zoom,
            middle: size.map(|s| 0.5 * s),
        })
    }

    /// Position in a frame of the same axes as the input whose longest side is 2.
    pub(crate) fn normal(&self, p: Vec3) -> Vec3 {
        normal_position(p, self.centre, self.scale)
    }

    /// A length of the input in camera space.
    pub(crate) fn length(&self, length: f64) -> f64 {
        length / self.scale
    }

    /// Camera space from the normal position.
    pub(crate) fn place(&self, p: Vec3) -> Vec3 {
        let [x, y, z] = turned(&self.axes, p);
        Vec3::new(x - self.shift[0], y - self.shift[1], z + self.distance)
    }

    /// A direction of the input in camera space.
    pub(crate) fn turn(&self, direction: Vec3) -> Vec3 {
        turned(&self.axes, direction).into()
    }

    /// Column and row in pixels (the first pixel is from 0 to 1) and one over the depth.
    pub(crate) fn screen(&self, p: Vec3) -> [f64; 3] {
        let near = 1.0 / p.z;
        let [x, y] = self.middle;
        [x + self.focal * p.x * near, y - self.focal * p.y * near, near]
    }

    /// Direction, of depth 1, in which the camera sees a place of the picture.
    pub(crate) fn ray(&self, x: f64, y: f64) -> Vec3 {
        Vec3::new((x - self.middle[0]) / self.focal, (self.middle[1] - y) / self.focal, 1.0)
    }
}

fn normal_position(p: Vec3, centre: Vec3, scale: f64) -> Vec3 {
    // Divided before the difference, which may overflow; the quotient of denormals is exact enough.
    if scale > 1e300 { p / scale - centre / scale } else { (p - centre) / scale }
}

fn turned([right, up, towards]: &[Vec3; 3], p: Vec3) -> [f64; 3] {
    [p.dot(*right), p.dot(*up), -p.dot(*towards)]
}
