//! A convex polygon of few vertices, held without a heap, and what half-planes leave of it.

use glam::DVec2;

/// The most vertices: an outline of 8, cut by a rectangle and by a shape of four sides.
const MOST: usize = 16;

/// A convex polygon of up to 16 vertices.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Convex {
    vertices: [DVec2; MOST],
    count: usize,
}

/// The area of a polygon, below zero where its vertices go round the other way.
#[inline]
pub(super) fn signed_area(outline: &[DVec2]) -> f64 {
    let Some(from) = outline.first() else { return 0.0 };
    0.5 * outline.windows(2).map(|pair| (pair[0] - *from).perp_dot(pair[1] - *from)).sum::<f64>()
}

/// The least and the largest coordinates of some points.
#[inline]
pub(super) fn bounds(points: &[DVec2]) -> [DVec2; 2] {
    let start = [DVec2::INFINITY, DVec2::NEG_INFINITY];
    points.iter().fold(start, |[low, high], p| [low.min(*p), high.max(*p)])
}

impl Convex {
    /// The polygon of these vertices, turned so that its area is not below zero: with y down, clockwise as it is seen.
    ///
    /// # Panics
    /// Of more than 16 vertices.
    #[inline]
    pub fn new(outline: &[DVec2]) -> Self {
        let mut polygon = Self { vertices: [DVec2::ZERO; MOST], count: outline.len() };
        polygon.vertices[..outline.len()].copy_from_slice(outline);
        if polygon.area() < 0.0 {
            polygon.vertices[..outline.len()].reverse();
        }
        polygon
    }

    /// Its vertices in order; none where nothing is left of it.
    #[inline(always)]
    pub fn vertices(&self) -> &[DVec2] {
        &self.vertices[..self.count]
    }

    /// Its area.
    #[inline]
    pub fn area(&self) -> f64 {
        signed_area(self.vertices())
    }

    /// The least and the largest coordinates.
    #[inline]
    pub fn bounds(&self) -> [DVec2; 2] {
        bounds(self.vertices())
    }

    /// Each vertex moved by `f`, which keeps lines straight and does not turn the polygon over.
    #[inline]
    #[must_use]
    pub fn map(&self, f: impl Fn(DVec2) -> DVec2) -> Self {
        let mut moved = *self;
        moved.vertices[..self.count].iter_mut().for_each(|p| *p = f(*p));
        moved
    }

    /// The part in which `inside`, a linear function, is not below zero (Sutherland & Hodgman 1974).
    #[inline]
    #[must_use]
    pub fn cut(&self, inside: impl Fn(DVec2) -> f64) -> Self {
        let mut kept = Self { vertices: [DVec2::ZERO; MOST], count: 0 };
        let mut keep = |p: DVec2| {
            // A convex polygon and a line make one vertex more at most; rounding must not make another.
            if kept.count < MOST {
                kept.vertices[kept.count] = p;
                kept.count += 1;
            }
        };
        for (k, a) in self.vertices().iter().enumerate() {
            let b = self.vertices[(k + 1) % self.count];
            let (here, there) = (inside(*a), inside(b));
            if here >= 0.0 {
                keep(*a);
            }
            if (here > 0.0 && there < 0.0) || (here < 0.0 && there > 0.0) {
                keep(a.lerp(b, here / (here - there)));
            }
        }
        kept
    }

    /// The part within a rectangle; the polygon itself where it lies in it.
    #[inline]
    #[must_use]
    pub fn within(&self, low: DVec2, high: DVec2) -> Self {
        let [least, most] = self.bounds();
        if low.cmple(least).all() && most.cmple(high).all() {
            return *self;
        }
        let mut part = *self;
        for axis in 0..2 {
            if least[axis] < low[axis] {
                part = part.cut(|p| p[axis] - low[axis]);
            }
            if most[axis] > high[axis] {
                part = part.cut(|p| high[axis] - p[axis]);
            }
        }
        part
    }

    /// The part within another convex polygon, whose vertices are in the order of one of positive area.
    #[inline]
    #[must_use]
    pub fn within_polygon(&self, outline: &[DVec2]) -> Self {
        let mut part = *self;
        for (k, a) in outline.iter().enumerate() {
            let along = outline[(k + 1) % outline.len()] - *a;
            part = part.cut(|p| along.perp_dot(p - *a));
        }
        part
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(low: f64, high: f64) -> Vec<DVec2> {
        [(low, low), (high, low), (high, high), (low, high)].map(DVec2::from).to_vec()
    }

    #[test]
    fn a_polygon_of_either_orientation_has_a_positive_area() {
        let mut outline = square(1.0, 3.0);
        assert_eq!(Convex::new(&outline).area(), 4.0);
        outline.reverse();
        assert_eq!(Convex::new(&outline).area(), 4.0);
    }

    /// Overlaps of two squares that are known without a program.
    #[test]
    fn what_is_within_another_is_their_overlap() {
        let own = Convex::new(&square(0.0, 2.0));
        let diamond = [(1.0, -1.0), (3.0, 1.0), (1.0, 3.0), (-1.0, 1.0)].map(DVec2::from);
        // Only its corners (0, 0), (2, 0) ... lie on the diamond's sides.
        assert_eq!(own.within_polygon(&diamond).area(), 4.0);
        let small = [(1.0, 0.0), (2.0, 1.0), (1.0, 2.0), (0.0, 1.0)].map(DVec2::from);
        assert_eq!(own.within_polygon(&small).area(), 2.0);
        assert_eq!(own.within(DVec2::splat(1.5), DVec2::splat(9.0)).area(), 0.25);
        assert_eq!(own.within(DVec2::splat(5.0), DVec2::splat(9.0)).area(), 0.0);
    }
}
