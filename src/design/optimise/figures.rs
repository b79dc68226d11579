//! How far a design's rays go from its law, by its polynomials.

use super::nodes::{PixelNode, SPOT_RAYS, opening};
use super::passage::{GlassRay, SmoothSheet, pass};
use super::start::depths_mm;
use crate::design::designed_law::DesignedLaw;
use crate::design::virtual_camera::VirtualCamera;
use crate::num::poly2::Poly2;
use crate::scene::{CameraSpec, DesignSettings};
use crate::surface::shape::PolynomialPatch;

use super::merit::HalfCamera;

/// Places along each side of the half image where a design is judged, its borders among them.
const GRID: usize = 41;
/// The same for spots.
const SPOT_GRID: usize = 9;

/// What the rays of a design miss its law by, from a board at one depth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LawFigures {
    /// z of the board in the prism's frame, in mm; may be infinite.
    pub depth_mm: f64,
    /// Root mean squares over 41 x 41 pixels of the half image, its borders among them, horizontal and vertical, in px.
    pub rms_px: [f64; 2],
    /// The largest length of a deviation, in px.
    pub max_px: f64,
}

/// Spots of a lens in front of the prism, of a board at one depth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpotFigures {
    /// Root mean square of the distance of a spot's rays from their middle, over the half image, in px.
    pub rms_px: f64,
    /// What must be added to the vergence -1/distance of the lens's focus for it to be smallest, in dioptres (1/m): negative where the
    /// lens must be focused nearer.
    pub refocus_dpt: f64,
}

/// The law of a design, and how well it is met.
#[derive(Debug, Clone, PartialEq)]
pub struct MetLaw {
    /// The law.
    pub law: DesignedLaw,
    /// What is missed at each depth at which it is to hold: of all depths between two the misses are no larger.
    pub figures: Vec<LawFigures>,
    /// Whether a higher degree gains little: a floor of the objective.
    pub floor_reached: bool,
    /// Spots, where the design has an aperture.
    pub spot: Option<SpotFigures>,
}

impl MetLaw {
    /// The larger root mean square length of a deviation at the ends of the depths, in px.
    pub fn rms_px(&self) -> f64 {
        self.figures.iter().map(|f| libm::hypot(f.rms_px[0], f.rms_px[1])).fold(0.0, f64::max)
    }

    /// The largest length of a deviation, in px.
    pub fn max_px(&self) -> f64 {
        self.figures.iter().map(|f| f.max_px).fold(0.0, f64::max)
    }
}

impl SmoothSheet<f64> for Poly2 {
    fn plain(&self, x: f64, y: f64) -> [f64; 3] {
        self.gradient(x, y).into()
    }

    fn lifted(&self, x: f64, y: f64) -> [f64; 3] {
        self.plain(x, y)
    }
}

/// How well polynomials meet `law`; `None` where a ray of the half image does not pass them.
pub(in crate::design) fn met_law(
    camera: &CameraSpec,
    target: &VirtualCamera,
    settings: &DesignSettings,
    patches: [&PolynomialPatch; 2],
    law: DesignedLaw,
) -> Option<MetLaw> {
    let judged = Judged {
        camera: HalfCamera::of(camera, target),
        half_mm: HalfCamera::half_mm(camera),
        sheets: patches.map(|p| &p.sag),
        law,
    };
    let figures = depths_mm(settings).into_iter().map(|depth_mm| judged.figures(depth_mm)).collect::<Option<_>>()?;
    let spot = match settings.goal.f_number {
        Some(f_number) => Some(judged.spot(0.5 * target.focal_length_mm / f_number, settings.goal.depth_mm)?),
        None => None,
    };
    Some(MetLaw { law, figures, floor_reached: false, spot })
}

/// What is judged.
struct Judged<'a> {
    camera: HalfCamera,
    half_mm: [f64; 2],
    sheets: [&'a Poly2; 2],
    law: DesignedLaw,
}

impl Judged<'_> {
    /// `count` x `count` places over the half image.
    fn places(&self, count: usize) -> impl Iterator<Item = PixelNode> + '_ {
        let share = move |k: usize| 2.0 * k as f64 / (count - 1) as f64 - 1.0;
        let [width, height] = self.half_mm;
        (0..count * count).map(move |k| PixelNode {
            u_mm: width * share(k % count),
            v_mm: height * share(k / count),
            weight: 1.0 / count as f64,
        })
    }

    /// Where the law's camera sees the end of a ray, in px.
    fn image_px(&self, ray: &GlassRay<f64>, depth_mm: f64, v_mm: f64) -> Option<[f64; 2]> {
        let exit = pass(ray, self.sheets, self.camera.index_ratio)?.exit;
        let image = self.law.of(self.camera.half_centre_mm).image(exit.origin, exit.direction, depth_mm, v_mm);
        Some(image.map(|c| c / self.camera.pitch_mm))
    }

    fn figures(&self, depth_mm: f64) -> Option<LawFigures> {
        let (mut squares, mut largest) = ([0.0; 2], 0.0f64);
        for PixelNode { u_mm, v_mm, weight } in self.places(GRID) {
            let image = self.image_px(&self.camera.ray(u_mm, v_mm), depth_mm, v_mm)?;
            let off = [image[0] - u_mm / self.camera.pitch_mm, image[1] - v_mm / self.camera.pitch_mm];
            squares = [0, 1].map(|k| squares[k] + weight * weight * off[k] * off[k]);
            largest = largest.max(libm::hypot(off[0], off[1]));
        }
        Some(LawFigures { depth_mm, rms_px: squares.map(f64::sqrt), max_px: largest })
    }

    /// Spots at the best focus. A spot is nearly linear in the inverse of the focused distance, so that two of them tell the best
    /// one.
    fn spot(&self, radius_mm: f64, depth_mm: f64) -> Option<SpotFigures> {
        let focus = 1.0 / depth_mm;
        let step = 1e-3;
        let (here, there) =
            (self.spot_rays(radius_mm, depth_mm, focus)?, self.spot_rays(radius_mm, depth_mm, focus + step)?);
        let by: Vec<f64> = here.iter().zip(&there).map(|(a, b)| (b - a) / step).collect();
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let refocus = -product(&here, &by) / product(&by, &by);
        let best = self.spot_rays(radius_mm, depth_mm, focus + refocus)?;
        Some(SpotFigures { rms_px: product(&best, &best).sqrt(), refocus_dpt: -1e3 * refocus })
    }

    /// Both coordinates of every ray of every spot from its middle, each times the root of its share, in px.
    fn spot_rays(&self, radius_mm: f64, depth_mm: f64, focus: f64) -> Option<Vec<f64>> {
        let mut all = Vec::new();
        for node in self.places(SPOT_GRID) {
            let seen = |place: [f64; 2]| {
                let ray = self.camera.ray_through(&node, place.map(|p| p * radius_mm), focus);
                self.image_px(&ray, depth_mm, node.v_mm)
            };
            let rays = opening().into_iter().map(seen).collect::<Option<Vec<_>>>()?;
            let share = node.weight / (SPOT_RAYS as f64).sqrt();
            for axis in [0, 1] {
                let middle = rays.iter().map(|ray| ray[axis]).sum::<f64>() / SPOT_RAYS as f64;
                all.extend(rays.iter().map(|ray| share * (ray[axis] - middle)));
            }
        }
        Some(all)
    }
}
