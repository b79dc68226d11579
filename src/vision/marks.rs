//! Marks in the squares of a board: those of a ChArUco board fill most of each bright square.
//!
//! What is near the edges of a square is the same as without them, and what of a mark reaches there, its black border, lies alike on
//! opposite sides of a corner. The rest of the squares then says nothing of the corner's light, and is left out of the fits.

use super::blur::{FIRST_MARGIN_PX, FIRST_SIGMA_PX};
use super::blur_shape::PictureBlur;
use super::candidates::Candidates;
use super::corner_site::CornerSite;
use super::pixel_sums::PixelSums;
use super::settings::Settings;
use super::window::Window;
use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;

/// A square holds a mark where the root mean square difference from even light is this share of the contrast: a mark has as much black
/// as white, noise that strong shows no board.
const MARKED: f64 = 0.2;
/// The squares of the other colour hold none: what they show is less than this share of it.
const PLAIN: f64 = 0.5;
/// One of so many corners is asked.
const ONE_OF: usize = 2;
/// Each colour fills at least this share of the window.
const LEAST_SHARE: f64 = 0.1;

/// Whether the squares of one colour hold marks, as most corners at `sites` show it in their windows.
pub(super) fn holds_marks(candidates: &Candidates<'_>, sites: &[CornerSite], settings: &Settings) -> bool {
    let blur = PictureBlur::gaussian([FIRST_SIGMA_PX; 2]);
    let frame = |site: &CornerSite| site.frame(&blur, site.half(settings.window, &blur), FIRST_MARGIN_PX);
    let marked = |site: &CornerSite| is_marked(&site.window(candidates, &frame(site)));
    let some: Vec<&CornerSite> = sites.iter().step_by(ONE_OF).collect();
    2 * some.par_iter().filter(|site| marked(site)).count() > some.len()
}

fn is_marked(window: &Window) -> bool {
    let [one, other] = window.flat.map(|sums| unevenness(&sums, LEAST_SHARE * window.weight));
    let Some(([mean, uneven], [other_mean, other_uneven])) = one.zip(other) else { return false };
    let (most, least) = (uneven.max(other_uneven), uneven.min(other_uneven));
    most > MARKED * (mean - other_mean).abs() && least < PLAIN * most
}

/// The mean of some pixels, and the root mean square of what is left of them by light that varies linearly; `None` where they are fewer
/// than `least`.
fn unevenness(sums: &PixelSums, least: f64) -> Option<[f64; 2]> {
    let [n, x, y, xx, xy, yy] = sums.moments;
    if n < least.max(9.0) {
        return None;
    }
    let light = Vector3::from(sums.light);
    let plane = Matrix3::new(n, x, y, x, xx, xy, y, xy, yy).cholesky()?.solve(&light);
    Some([light[0] / n, ((sums.square - plane.dot(&light)) / n).max(0.0).sqrt()])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::Raster;
    use crate::vision::pixel_sums::WindowFrame;
    use crate::vision::window::gather;
    use glam::{DMat2, DVec2};

    fn window(value: impl Fn(f64, f64) -> f64) -> Window {
        let at = |k: usize| value((k % 60) as f64 - 29.5, (k / 60) as f64 - 29.5) as f32;
        let image = Raster::from_data(60, 60, (0..3600).map(at).collect());
        let frame = WindowFrame {
            centre: DVec2::splat(30.0),
            steps: DMat2::from_diagonal(DVec2::splat(45.0)),
            normals: [DVec2::NEG_X, DVec2::Y],
            bands_px: [3.0; 2],
            half: 0.45,
        };
        gather(&image, None, &frame)
    }

    #[test]
    fn marks_are_told_from_plain_squares_noise_and_light() {
        let bright = |x: f64, y: f64| x * y > 0.0;
        let bits = |x: f64, y: f64| (x / 3.0).floor() as i32 * 7 + (y / 3.0).floor() as i32 * 3;
        let inside = |x: f64, y: f64| x.abs().min(y.abs()) > 5.0;
        let marked = |x: f64, y: f64| bright(x, y) && !(inside(x, y) && bits(x, y) % 2 == 0);
        assert!(is_marked(&window(|x, y| if marked(x, y) { 0.8 } else { 0.1 })));
        // The same as a negative, on a board whose dark squares hold bright marks.
        assert!(is_marked(&window(|x, y| if marked(x, y) { 0.1 } else { 0.8 })));
        assert!(!is_marked(&window(|x, y| if bright(x, y) { 0.8 } else { 0.1 })));
        assert!(!is_marked(&window(|x, y| (if bright(x, y) { 0.8 } else { 0.1 }) * (1.0 + 0.02 * x))));
        // Strong noise is in both colours.
        let noise = |x: f64, y: f64| f64::from(bits(4.0 * x, 4.0 * y) % 5) * 0.1;
        assert!(!is_marked(&window(|x, y| noise(x, y) + if bright(x, y) { 0.8 } else { 0.1 })));
    }
}
