//! The two halves of a biprism's picture: cut apart before anything is detected, so that no window and no
//! grid reaches over the seam.

use crate::raster::Raster;
use glam::DVec2;
use std::ops::Range;

/// A half of the *image* (not of the prism).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Half {
    /// The columns left of the seam.
    Left,
    /// The columns right of the seam.
    Right,
}

impl Half {
    /// Both halves, left first.
    pub const BOTH: [Self; 2] = [Self::Left, Self::Right];

    /// The name in files and reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Left => "left",
            Self::Right => "right",
        }
    }
}

/// One half of a picture, with its place in the whole.
#[derive(Debug, Clone, PartialEq)]
pub struct HalfImage<T> {
    /// Which half.
    pub half: Half,
    /// The full image's column that is column 0 of [`HalfImage::image`].
    pub first_column: usize,
    /// The half's own pixels.
    pub image: Raster<T>,
}

impl<T> HalfImage<T> {
    /// A position of this half's own picture, in px, as a position in the full image.
    pub fn full_from_half(&self, position_px: DVec2) -> DVec2 {
        position_px + DVec2::new(self.first_column as f64, 0.0)
    }
}

impl<T: Copy> HalfImage<T> {
    /// One half of a picture, cut at its middle. The middle column of an odd width sees both sides of the seam and belongs
    /// to neither half.
    pub fn cut(image: &Raster<T>, half: Half) -> Self {
        let width = image.width();
        let columns = columns_of(width, half);
        Self { half, first_column: columns.start, image: image.columns(columns.start, columns.end) }
    }
}

/// The columns of one half of a picture of `width` columns, as [`HalfImage::cut`] takes them.
pub(crate) fn columns_of(width: usize, half: Half) -> Range<usize> {
    if half == Half::Left { 0..width / 2 } else { width.div_ceil(2)..width }
}

/// The left and the right half of a picture: [`HalfImage::cut`].
pub fn split<T: Copy>(image: &Raster<T>) -> [HalfImage<T>; 2] {
    Half::BOTH.map(|half| HalfImage::cut(image, half))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_odd_middle_column_belongs_to_neither_half() {
        let image = Raster::from_data(5, 1, vec![0, 1, 2, 3, 4]);
        let [left, right] = split(&image);
        assert_eq!((left.image.data(), right.image.data()), (&[0, 1][..], &[3, 4][..]));
        assert_eq!(right.full_from_half(DVec2::new(0.5, 0.5)), DVec2::new(3.5, 0.5));
    }

    #[test]
    fn an_even_width_is_shared_and_a_single_column_vanishes() {
        let [left, right] = split(&Raster::filled(4, 2, 0.0));
        assert_eq!((left.image.width(), right.image.width(), right.first_column), (2, 2, 2));
        let [left, right] = split(&Raster::filled(1, 1, 0.0));
        assert_eq!((left.image.width(), right.image.width()), (0, 0));
    }
}
