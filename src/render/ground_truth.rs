//! What is true of a picture: what the centre of every pixel sees, through the middle of the pupil, in the scene's light.

use super::bands::picture;
use super::film::{Film, Outputs};
use super::plan::Plan;
use crate::system::{InLight, System};

/// The picture of `system` through the middle of its pupil, in light of the wavelength with the largest share, with its
/// ground truth: classes are those of that light, board positions the mean over all wavelengths whose rays pass the same
/// side, weighted by what the sensor receives of each.
pub(super) fn ground_truth(system: &System) -> Film {
    let light = InLight::new(system);
    let whole = |system: &System| picture(&Plan::new(system), Outputs { truth: true }, &());
    let mut film = whole(light.main());
    let [(main_share, _), others @ ..] = light.lights() else { return film };
    if others.is_empty() {
        return film;
    }

    let (Some(class), Some(board_mm)) = (&film.class, &mut film.board_mm) else { return film };
    let objects = &film.object;

    // Sum up the board positions of each wavelength where it passes the side of the main one.
    let start = |mm: &[f32; 2]| [f64::from(mm[0]) * main_share, f64::from(mm[1]) * main_share, *main_share];
    let mut sums: Vec<[f64; 3]> = board_mm.data().iter().map(start).collect();
    for (share, system) in others {
        let other = whole(system);
        let (Some(other_class), Some(other_mm)) = (&other.class, &other.board_mm) else { continue };
        let classes = class.data().iter().zip(other_class.data());
        let object = |film: &Film, k: usize| film.object.as_ref().map(|object| object.data()[k]);
        for (k, (sum, ((class, other_class), mm))) in sums.iter_mut().zip(classes.zip(other_mm.data())).enumerate() {
            let same = objects.as_ref().map(|objects| objects.data()[k]) == object(&other, k);
            if same && class == other_class && class.side().is_some() {
                let [x, y] = mm.map(f64::from);
                *sum = [sum[0] + x * share, sum[1] + y * share, sum[2] + share];
            }
        }
    }

    // Divide by the shares that arrived.
    for (mm, [x, y, share]) in board_mm.data_mut().iter_mut().zip(sums) {
        if share > 0.0 {
            *mm = [(x / share) as f32, (y / share) as f32];
        }
    }
    film
}
