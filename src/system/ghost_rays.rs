//! The prism as a piece of glass whose surfaces reflect: light that does not go straight through.

use super::instrument::System;
use crate::effect::Ghosts;
use crate::optics::polarisation::{Beam, PolarisationState};
use crate::prism::reflections::{Exit, GlassBody, Limits, ReflectionTracer};
use glam::DVec2;

impl System {
    /// What light meets in the glass, with all that the scene's effects say of its surfaces and its substance; `None` without
    /// a prism.
    pub fn body(&self) -> Option<GlassBody> {
        let [n_outer, n_glass] = self.prism.as_ref()?.indices();
        let effects = &self.effects;
        Some(GlassBody {
            n_outer,
            n_glass,
            layers: [effects.coating.map(|coating| coating.layer); 2],
            wavelength_nm: effects.coating.map_or(f64::INFINITY, |coating| coating.wavelength_nm),
            absorption_per_mm: effects.absorption.map_or(0.0, |absorption| absorption.per_mm),
        })
    }

    /// Tells of all light that leaves the glass after reflections, with its power of the 1 that comes as `light` from the image
    /// position `px` into `body`.
    pub fn reflected(
        &self,
        px: DVec2,
        light: PolarisationState,
        body: GlassBody,
        ghosts: &Ghosts,
        mut tell: impl FnMut(&Exit),
    ) {
        let Some(prism) = &self.prism else { return };
        let ray = self.camera.ray(px);
        if self.stops(&ray) {
            return;
        }
        let limits = Limits { bounces: ghosts.bounces, least_power: ghosts.least_power };
        let start = Beam::new(ray.direction, light);
        let tracer = ReflectionTracer { prism, body, limits, residual_mm: self.accuracy.surface_residual_mm };
        tracer.trace(&ray, start, &mut |exit: &Exit| {
            // The light that is never reflected is the picture itself.
            if exit.bounces > 0 {
                tell(exit);
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene;
    use crate::surface::face::Face;
    use crate::system::build::build;

    fn system(prism: &str) -> System {
        let text = format!(
            "name = \"t\"\n[camera]\nfocal_length_mm = 35\nwidth_px = 192\nheight_px = 108\npixel_pitch_um = 55\n\
             [prism]\n{prism}\nindex = 1.48\nridge_distance_mm = 78.472\nthickness_mm = 8.545\n[board]\ncolumns = 9\n\
             rows = 9\nsquare_mm = 20\nposition_mm = [0, 0, 1000]\n"
        );
        build(&scene::parse(&text, "t", None).unwrap()).unwrap()
    }

    /// Light that no surface reflects goes the way that the picture itself goes.
    #[test]
    fn straight_light_takes_the_way_of_the_picture() {
        for prism in ["kind = \"flat\"", "kind = \"flat\"\ntilt_deg = [3, -2, 5]", "kind = \"freeform\""] {
            let system = system(prism);
            let prism = system.prism().unwrap();
            let limits = Limits { bounces: 0, least_power: 0.0 };
            let tracer = ReflectionTracer { prism, body: system.body().unwrap(), limits, residual_mm: 1e-12 };
            for k in 0..500 {
                let px = DVec2::new(0.384 * f64::from(k), 54.0 + 53.0 * libm::sin(f64::from(k)));
                let ray = system.camera().ray(px);
                let mut found = Vec::new();
                let start = Beam::new(ray.direction, PolarisationState::Unpolarised);
                tracer.trace(&ray, start, &mut |exit| found.push(*exit));
                let (wanted, side) = system.exit_ray(px).unwrap();
                assert_eq!(found.len(), 1, "{px}");
                assert_eq!((found[0].ray, found[0].last.side), (wanted, side), "{px}");
            }
        }
    }

    /// Light that is followed to the end is all accounted for, and the ghosts of the paper's prism are as weak as R^2.
    #[test]
    fn ghosts_are_weak_and_all_light_is_accounted_for() {
        for (prism, flat) in [("kind = \"flat\"", true), ("kind = \"freeform\"", false)] {
            let system = system(prism);
            let prism = system.prism().unwrap();
            for k in 0..200 {
                let px = DVec2::new(0.96 * f64::from(k), 54.0 + 53.0 * libm::cos(f64::from(k)));
                let ray = system.camera().ray(px);
                let start = Beam::new(ray.direction, PolarisationState::Unpolarised);
                let limits = Limits { bounces: 6, least_power: 1e-12 };
                let tracer = ReflectionTracer { prism, body: system.body().unwrap(), limits, residual_mm: 1e-12 };
                let mut ghost = 0.0;
                let account = tracer.trace(&ray, start, &mut |exit| {
                    if exit.bounces > 0 && exit.last.face == Face::Back {
                        ghost += exit.power;
                    }
                });
                assert!((account.escaped + account.dropped - 1.0).abs() < 1e-12, "{account:?}");
                // R = (0.48 / 2.48)^2 = 0.0375 along the normal, up to 0.041 at the 25 degrees that occur.
                assert!(ghost < 0.041 * 0.041 * 1.1, "{px}: {ghost}");
                // A designed surface is given no further than the straight light needs it, and ghosts stray beyond.
                assert!(ghost > 0.9 * 0.0375 * 0.0375 || (!flat && account.dropped > 1e-3), "{px}: {ghost}");
            }
        }
    }
}
