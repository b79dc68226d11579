//! Supersampling: the mean of point samples a pixel, as a general renderer takes it that knows nothing of its scene.

use super::board_face::{faces, point_radiance};
use super::centre_rays::{CentreTracer, Run, trace_scalar};
use super::film::Class;
use super::plan::BAND_ROWS;
use crate::raster::Raster;
use crate::system::System;
use glam::DVec2;
use rayon::prelude::*;

/// Where the samples of a pixel lie.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SamplePlaces {
    /// At the centres of n x n equal parts, traced by packets.
    Grid,
    /// Anywhere in n x n equal parts, independently: stratified random sampling, the same on every run.
    Jittered,
}

/// The mean of n x n point samples a pixel, each traced.
pub fn supersampled(system: &System, n: usize, samples: SamplePlaces) -> Raster<f32> {
    let [width, height] = system.camera().size_px();
    let faces = faces(system);
    let centre_tracer = CentreTracer::new(system, true);
    let mut picture = Raster::filled(width, height, 0.0f32);

    // Sample band by band, in parallel.
    picture.data_mut().par_chunks_mut(width * BAND_ROWS).enumerate().for_each(|(band, rows)| {
        let (mut x_mm, mut y_mm, mut class) = (vec![0.0; width], vec![0.0; width], vec![Class::Left; width]);
        let mut sums = vec![0.0; width];
        for (k, row) in rows.chunks_mut(width).enumerate() {
            let j = band * BAND_ROWS + k;
            sums.fill(0.0);

            // Add one sample of each pixel at a time.
            for part in 0..n * n {
                let corner = DVec2::new((part % n) as f64, j as f64 * n as f64 + (part / n) as f64) / n as f64;

                let jittered = |i: usize| {
                    let jitter = random((j * width + i) as u64 * (n * n) as u64 + part as u64);
                    corner + DVec2::new(i as f64, 0.0) + jitter / n as f64
                };
                let place = |i: usize| match samples {
                    SamplePlaces::Grid => corner + 0.5 / n as f64 + DVec2::new(i as f64, 0.0),
                    SamplePlaces::Jittered => jittered(i),
                };

                // Trace the samples of the row.
                match samples {
                    SamplePlaces::Grid => {
                        let start = corner + 0.5 / n as f64;
                        centre_tracer.trace(start, Run { x_mm: &mut x_mm, y_mm: &mut y_mm, class: &mut class });
                    }
                    SamplePlaces::Jittered => {
                        for i in 0..width {
                            let (seen_mm, own) = trace_scalar(system, jittered(i));
                            (x_mm[i], y_mm[i], class[i]) = (seen_mm.x, seen_mm.y, own);
                        }
                    }
                }

                // Add the radiance that they see.
                for i in 0..width {
                    sums[i] += match class[i] {
                        Class::Left | Class::Right | Class::PastBoard if faces.len() > 1 => {
                            system.exit_ray(place(i)).map_or(0.0, |(ray, _)| point_radiance(system, &faces, &ray))
                        }
                        Class::Left | Class::Right => faces[0].at(DVec2::new(x_mm[i], y_mm[i])),
                        Class::PastBoard => faces[0].background(),
                        _ => 0.0,
                    };
                }
            }

            // Divide by the number of samples.
            for (pixel, sum) in row.iter_mut().zip(&sums) {
                *pixel = (sum / (n * n) as f64) as f32;
            }
        }
    });
    picture
}

/// Two numbers in 0..1 that look random and belong to `index` (splitmix64, Steele, Lea & Flood 2014).
fn random(index: u64) -> DVec2 {
    let mix = |k: u64| {
        let mut z = k.wrapping_mul(0x9E37_79B9_7F4A_7C15);
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    };
    DVec2::new(mix(2 * index + 1), mix(2 * index + 2))
}
