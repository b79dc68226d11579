//! A picture of values on a grid of pixels, and how large it may be.

/// Pictures have at most this many columns and this many rows.
pub const MAX_SIDE_PX: usize = 65_535;

/// Pictures have at most this many pixels: 1 GiB of f32.
pub const MAX_PIXELS: usize = 1 << 28;

/// A picture of `width` x `height` values, row by row from the top left.
///
/// Pixel (i, j) covers `[i, i+1) x [j, j+1)`; its centre is at (i + 0.5, j + 0.5).
#[derive(Debug, Clone, PartialEq)]
pub struct Raster<T> {
    width: usize,
    height: usize,
    data: Vec<T>,
}

impl<T: Copy> Raster<T> {
    /// A picture of one value.
    pub fn filled(width: usize, height: usize, value: T) -> Self {
        Self { width, height, data: vec![value; width * height] }
    }

    /// A picture of the given values, row by row.
    ///
    /// # Panics
    /// When `data` does not hold `width * height` values.
    pub fn from_data(width: usize, height: usize, data: Vec<T>) -> Self {
        assert_eq!(data.len(), width * height, "a raster needs width x height values");
        Self { width, height, data }
    }

    /// Columns.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// All values, row by row.
    pub fn data(&self) -> &[T] {
        &self.data
    }

    /// All values, row by row, and nothing else of it: a copy is not made.
    pub fn into_data(self) -> Vec<T> {
        self.data
    }

    /// All values, row by row, to be changed.
    pub fn data_mut(&mut self) -> &mut [T] {
        &mut self.data
    }

    /// Row `j`.
    pub fn row(&self, j: usize) -> &[T] {
        &self.data[j * self.width..(j + 1) * self.width]
    }

    /// Row `j`, to be changed.
    pub fn row_mut(&mut self, j: usize) -> &mut [T] {
        &mut self.data[j * self.width..(j + 1) * self.width]
    }

    /// The value of pixel (i, j).
    #[inline(always)]
    pub fn get(&self, i: usize, j: usize) -> T {
        self.data[j * self.width + i]
    }

    /// The columns `[first, last)` as a picture of their own.
    #[must_use]
    pub fn columns(&self, first: usize, last: usize) -> Self {
        let mut data = Vec::with_capacity((last - first) * self.height);
        (0..self.height).for_each(|j| data.extend_from_slice(&self.row(j)[first..last]));
        Self::from_data(last - first, self.height, data)
    }

    /// The picture without `frame` pixels on every side.
    #[must_use]
    pub fn without_frame(&self, frame: usize) -> Self {
        let (width, height) = (self.width - 2 * frame, self.height - 2 * frame);
        let rows = (frame..frame + height).flat_map(|j| &self.row(j)[frame..frame + width]);
        Self::from_data(width, height, rows.copied().collect())
    }

    /// Each value changed by `f`.
    #[must_use]
    pub fn map<U: Copy>(&self, f: impl Fn(T) -> U) -> Raster<U> {
        Raster::from_data(self.width, self.height, self.data.iter().map(|&v| f(v)).collect())
    }
}
