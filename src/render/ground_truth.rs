//! What is true of a picture: what the centre of every pixel sees, through the middle of the pupil, in the scene's light.

use super::band::{Band, Truth};
use super::bands::{picture, render_band};
use super::film::{Class, Film, Outputs};
use super::plan::{BAND_ROWS, Plan};
use crate::raster::Raster;
use crate::system::{InLight, System};
use rayon::prelude::*;

/// The ground truth of `system` through the middle of its pupil, as a film without a picture: classes are those of light of the
/// wavelength with the largest share, board positions the mean over all wavelengths whose rays pass the same side, weighted by what
/// the sensor receives of each.
pub(super) fn ground_truth(system: &System) -> Film {
    let light = InLight::new(system);
    let mut film = picture(&Plan::of_truth(light.main()), Outputs { truth: true }, &());
    let [(main_share, _), others @ ..] = light.lights() else { return film };
    if others.is_empty() {
        return film;
    }
    let plans: Vec<(f64, Plan)> = others.par_iter().map(|(share, system)| (*share, Plan::of_truth(system))).collect();

    // Take the means band by band.
    let (Some(class), Some(board_mm)) = (&film.class, &mut film.board_mm) else { return film };
    let width = class.width();
    let size = width * BAND_ROWS;
    let object_of = |k: usize| film.object.as_ref().map(|object| object.data().chunks(size).nth(k).unwrap_or_default());
    let bands = class.data().par_chunks(size).zip(board_mm.data_mut().par_chunks_mut(size)).enumerate();
    bands.with_max_len(1).for_each(|(k, (class, board_mm))| {
        let main = MainBand { width, first_row: k * BAND_ROWS, class, object: object_of(k) };
        main.take_mean(*main_share, &plans, board_mm);
    });
    film
}

/// The classes of [`ground_truth`].
pub(super) fn classes(system: &System) -> Option<Raster<Class>> {
    picture(&Plan::of_truth(InLight::new(system).main()), Outputs { truth: true }, &()).class
}

/// A band in light of the main wavelength.
struct MainBand<'a> {
    width: usize,
    first_row: usize,
    class: &'a [Class],
    object: Option<&'a [u32]>,
}

impl MainBand<'_> {
    /// Makes the board positions in that light, of share `main_share`, the mean of those and of the ones of `plans`.
    fn take_mean(&self, main_share: f64, plans: &[(f64, Plan)], board_mm: &mut [[f32; 2]]) {
        // Sum up the board positions of each wavelength where it passes the side of the main one.
        let size = self.class.len();
        let start = |mm: &[f32; 2]| [f64::from(mm[0]) * main_share, f64::from(mm[1]) * main_share, main_share];
        let mut sums: Vec<[f64; 3]> = board_mm.iter().map(start).collect();
        let (mut radiance, mut class, mut mm) = (vec![0.0; size], vec![Class::Left; size], vec![[0.0; 2]; size]);
        let mut object = self.object.map(|object| vec![0; object.len()]);
        for (share, plan) in plans {
            let truth = Truth { class: &mut class, board_mm: &mut mm, object: object.as_deref_mut() };
            let (width, first_row) = (self.width, self.first_row);
            let mut band = Band { width, first_column: 0, first_row, radiance: &mut radiance, truth: Some(truth) };
            render_band(plan, &mut band);
            for (k, sum) in sums.iter_mut().enumerate() {
                let same = self.object.map(|object| object[k]) == object.as_ref().map(|object| object[k]);
                if same && self.class[k] == class[k] && class[k].side().is_some() {
                    let [x, y] = mm[k].map(f64::from);
                    *sum = [sum[0] + x * share, sum[1] + y * share, sum[2] + share];
                }
            }
        }

        // Divide by the shares that arrived.
        for (mm, [x, y, share]) in board_mm.iter_mut().zip(sums) {
            if share > 0.0 {
                *mm = [(x / share) as f32, (y / share) as f32];
            }
        }
    }
}
