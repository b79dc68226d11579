//! Pictures of half the resolution.

use crate::raster::Raster;

/// The picture with each two by two pixels made one; an odd last row or column is left out.
pub(super) fn halved(image: &Raster<f32>) -> Raster<f32> {
    let (width, height) = (image.width() / 2, image.height() / 2);
    let mut data = Vec::with_capacity(width * height);
    for j in 0..height {
        let pairs = |row: usize| image.row(row).as_chunks::<2>().0;
        let sums = pairs(2 * j).iter().zip(pairs(2 * j + 1));
        data.extend(sums.map(|([a, b], [c, d])| 0.25 * ((a + b) + (c + d))));
    }
    Raster::from_data(width, height, data)
}

/// Which pixels of [`halved`] count: those of which all four do.
pub(super) fn halved_mask(valid: &Raster<bool>) -> Raster<bool> {
    let (width, height) = (valid.width() / 2, valid.height() / 2);
    let all =
        |i: usize, j: usize| [(0, 0), (1, 0), (0, 1), (1, 1)].iter().all(|(a, b)| valid.get(2 * i + a, 2 * j + b));
    let data = (0..width * height).map(|k| all(k % width, k / width));
    Raster::from_data(width, height, data.collect())
}
