//! The renderer of one pass: band by band, in parallel.

use super::band::{Band, Truth};
use super::film::{Class, Film, Outputs, Strip};
use super::plan::{BAND_ROWS, Plan};
use super::work::Work;
use super::{layers, mapped, reference, seam_pixels, tile};
use crate::accuracy::Sampling;
use crate::progress::Observer;
use crate::raster::Raster;
use rayon::prelude::*;
use std::ops::Range;

/// The picture of a plan, one pass without film effects, with what is wanted of it; `observer` as in
/// [`render`](fn@super::render).
pub fn picture(plan: &Plan, wanted: Outputs, observer: &dyn Observer) -> Film {
    let [_, height] = plan.system.camera().size_px();
    let (Strip { radiance, colour, noise, class, board_mm, object }, done) = rows(plan, 0..height, wanted, observer);
    let mut work = plan.work();
    work += done;
    Film { radiance, colour, noise, class, board_mm, object, counts: work.counts, account: plan.account_of(&work) }
}

/// The `rows` of the picture of a plan, the first of which is a multiple of [`BAND_ROWS`], and the work they were; `wanted`
/// and `observer` as in [`picture`].
pub(super) fn rows(plan: &Plan, rows: Range<usize>, wanted: Outputs, observer: &dyn Observer) -> (Strip, Work) {
    // Allocate the rows, and the truth where it is wanted.
    let [width, _] = plan.system.camera().size_px();
    let mut radiance = Raster::filled(width, rows.len(), 0.0);
    let mut class = wanted.truth.then(|| Raster::filled(width, rows.len(), Class::Left));
    let mut board_mm = wanted.truth.then(|| Raster::filled(width, rows.len(), [0.0; 2]));

    let many = wanted.truth && !plan.objects.is_empty();
    let mut object = many.then(|| Raster::filled(width, rows.len(), 0u32));

    // Cut them into bands.
    let size = width * BAND_ROWS;
    let classes = class.iter_mut().flat_map(|class| class.data_mut().chunks_mut(size));
    let places = board_mm.iter_mut().flat_map(|board_mm| board_mm.data_mut().chunks_mut(size));
    let mut objects = object.iter_mut().flat_map(|object| object.data_mut().chunks_mut(size));
    let mut truths = classes.zip(places);
    let bands: Vec<Band> = (radiance.data_mut().chunks_mut(size).enumerate())
        .map(|(k, radiance)| {
            let truth = truths.next().map(|(class, board_mm)| Truth { class, board_mm, object: objects.next() });
            Band { width, first_column: 0, first_row: rows.start + k * BAND_ROWS, radiance, truth }
        })
        .collect();

    // Render the bands in parallel.
    let done: Vec<Work> = bands
        .into_par_iter()
        .with_max_len(1)
        .map(|mut band| {
            // One that ends the work does so before a band, not after it.
            observer.pixels(0);
            let work = render_band(plan, &mut band);
            observer.pixels(band.radiance.len());
            work
        })
        .collect();

    // Sum up their work in the order of the bands.
    let mut work = Work::default();
    done.into_iter().for_each(|w| work += w);
    (Strip { radiance, colour: None, noise: None, class, board_mm, object }, work)
}

// Apart, so that its instructions can be counted by its name.
#[inline(never)]
pub(super) fn render_band(plan: &Plan, band: &mut Band) -> Work {
    if plan.objects.is_empty() { band_alone(plan, band) } else { layers::render(plan, band, band_alone) }
}

/// Renders a band of a picture that is copied from the right half, but for its left one.
#[inline(never)]
pub(super) fn render_half(plan: &Plan, band: &mut Band) -> Work {
    own_band(plan, band)
}

/// Renders a band of the board alone.
#[inline(always)]
fn band_alone(plan: &Plan, band: &mut Band) -> Work {
    let work = own_band(plan, band);
    if plan.mirrored {
        band.mirror();
    }
    work
}

/// Renders what of a band of the board alone is not copied.
#[inline(always)]
fn own_band(plan: &Plan, band: &mut Band) -> Work {
    if plan.system.accuracy().sampling == Sampling::SingleRays {
        return reference::render(plan, band);
    }
    let mut work = Work::default();
    for patch in &plan.patches {
        work += mapped::render(plan, patch, band);
    }
    for seam in &plan.seams {
        work += seam_pixels::render(plan, seam, band);
    }
    for region in &plan.traced {
        work += tile::render(plan, &band.part_of(region), band);
    }
    work
}

/// Renders the part of the picture of a plan, which is not copied from its mirror image, that `band` covers.
pub(super) fn render_part(plan: &Plan, band: &mut Band) {
    if plan.objects.is_empty() {
        part_alone(plan, band)
    } else {
        layers::render(plan, band, part_alone)
    };
}

/// The same of the board alone.
fn part_alone(plan: &Plan, band: &mut Band) -> Work {
    let mut work = Work::default();
    for patch in &plan.patches {
        let region = band.part_of(&patch.region);
        if region.columns.len() < mapped::LEAST_COLUMNS {
            work += tile::render(plan, &region, band);
        } else if !region.rows.is_empty() {
            work += mapped::render(plan, &patch.part(region), band);
        }
    }
    for seam in &plan.seams {
        work += seam_pixels::render(plan, seam, band);
    }
    for region in &plan.traced {
        work += tile::render(plan, &band.part_of(region), band);
    }
    work
}
