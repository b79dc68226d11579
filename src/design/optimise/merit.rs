//! What a design is to make small: how far its rays go from its law at the ends of the depths, and how wide its spots are.

use super::nodes::{PixelNode, SPOT_RAYS, opening};
use super::passage::{FOCUS_SEED, Fixed, GlassPassage, GlassRay, LAW_SEED, Moving, Partial, Seeded, SmoothSheet, pass};
use super::unknowns::UnknownsLayout;
use crate::design::designed_law::LawOf;
use crate::design::virtual_camera::VirtualCamera;
use crate::num::geodesic::Merit;
use crate::num::scalar::{Differentiable, Taylor};
use crate::scene::CameraSpec;
use nalgebra::{DMatrix, DVector};

/// The camera as the search needs it: the right half of a pinhole along +z at the origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct HalfCamera {
    pub(super) focal_length_mm: f64,
    /// b, from the middle of the sensor to that of the half image.
    pub(super) half_centre_mm: f64,
    pub(super) pitch_mm: f64,
    /// n_glass / n_outside.
    pub(super) index_ratio: f64,
}

/// Spots of a lens with an opening, of a board at one depth.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SpotMerit {
    /// Radius of the opening, in mm.
    pub(super) radius_mm: f64,
    /// How much a spot counts against a deviation of the same size.
    pub(super) weight: f64,
    /// z of the board, and where the lens is focused but for what the search adds.
    pub(super) depth_mm: f64,
    /// Where spots are.
    pub(super) nodes: Vec<PixelNode>,
}

/// Residuals in px whose sum of squares is the mean square over the half image, over depths, and over both directions' sum.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct LawMerit {
    pub(super) layout: UnknownsLayout,
    pub(super) camera: HalfCamera,
    pub(super) nodes: Vec<PixelNode>,
    /// z of the depths, in mm; infinity is one.
    pub(super) depths_mm: Vec<f64>,
    pub(super) spot: Option<SpotMerit>,
}

/// Both surfaces, the law and the focus, over one kind of number.
pub(super) struct Instrument<N, S> {
    pub(super) sheets: [S; 2],
    pub(super) law: LawOf<N>,
    pub(super) focus: Option<N>,
}

impl HalfCamera {
    /// The right half of `camera` before the glass of `target`.
    pub(super) fn of(camera: &CameraSpec, target: &VirtualCamera) -> Self {
        let VirtualCamera { focal_length_mm, half_centre_mm, index_ratio, .. } = *target;
        Self { focal_length_mm, half_centre_mm, pitch_mm: camera.pitch_mm, index_ratio }
    }

    /// Half width and half height of a half image.
    pub(super) fn half_mm(camera: &CameraSpec) -> [f64; 2] {
        [0.25 * camera.width_px as f64, 0.5 * camera.height_px as f64].map(|px| px * camera.pitch_mm)
    }

    /// The ray of a pixel through the pinhole.
    pub(super) fn ray<N: Differentiable>(&self, u_mm: f64, v_mm: f64) -> GlassRay<N> {
        let zero = N::constant(0.0);
        let tangents = [(self.half_centre_mm + u_mm) / self.focal_length_mm, v_mm / self.focal_length_mm, 1.0];
        GlassRay { origin: [zero; 3], direction: tangents.map(N::constant) }
    }

    /// The ray of the same pixel through a place of the opening, focused at the inverse distance `focus`.
    pub(super) fn ray_through<N: Differentiable>(&self, node: &PixelNode, place_mm: [f64; 2], focus: N) -> GlassRay<N> {
        let GlassRay { direction: [x, y, z], .. } = self.ray::<N>(node.u_mm, node.v_mm);
        let [px, py] = place_mm;
        GlassRay { origin: [px, py, 0.0].map(N::constant), direction: [x - focus.times(px), y - focus.times(py), z] }
    }
}

impl LawMerit {
    /// Each ray with its residuals, in the order of the rows; those of a spot before their mean is taken off.
    fn visit<N: Differentiable, S: SmoothSheet<N>>(
        &self,
        with: &Instrument<N, S>,
        mut each: impl FnMut(&[N], &GlassPassage<N>),
    ) -> Option<()> {
        let Instrument { sheets: [front, back], law, focus } = with;
        let Self { camera, depths_mm, .. } = self;

        // Rays of the law, at each depth.
        for node in &self.nodes {
            let passage = pass(&camera.ray(node.u_mm, node.v_mm), [front, back], camera.index_ratio)?;
            let scale = node.weight / camera.pitch_mm / (depths_mm.len() as f64).sqrt();
            let mut rows = [N::constant(0.0); 4];
            for (pair, depth_mm) in rows.chunks_exact_mut(2).zip(depths_mm) {
                let [u, v] = law.image(passage.exit.origin, passage.exit.direction, *depth_mm, node.v_mm);
                pair[0] = (u - N::constant(node.u_mm)).times(scale);
                pair[1] = (v - N::constant(node.v_mm)).times(scale);
            }
            each(&rows[..2 * depths_mm.len()], &passage);
        }

        // Rays of the spots, through the whole opening.
        let Some(spot) = &self.spot else { return Some(()) };
        let focus = focus.unwrap_or(N::constant(1.0 / spot.depth_mm));
        for node in &spot.nodes {
            let scale = spot.weight * node.weight / camera.pitch_mm / (SPOT_RAYS as f64).sqrt();
            for place in opening() {
                let ray = camera.ray_through(node, place.map(|p| p * spot.radius_mm), focus);
                let passage = pass(&ray, [front, back], camera.index_ratio)?;
                let image = law.image(passage.exit.origin, passage.exit.direction, spot.depth_mm, node.v_mm);
                each(&image.map(|c| c.times(scale)), &passage);
            }
        }
        Some(())
    }

    /// Rows of the law alone.
    fn law_rows(&self) -> usize {
        2 * self.depths_mm.len() * self.nodes.len()
    }

    /// All rows.
    fn rows(&self) -> usize {
        let spots = self.spot.as_ref().map_or(0, |spot| spot.nodes.len());
        self.law_rows() + 2 * SPOT_RAYS * spots
    }

    /// Takes the mean of each spot off its rays' rows.
    fn about_middle(&self, column: &mut [f64]) {
        for spot in column[self.law_rows()..].chunks_exact_mut(2 * SPOT_RAYS) {
            for axis in [0, 1] {
                let mean = spot.iter().skip(axis).step_by(2).sum::<f64>() / SPOT_RAYS as f64;
                spot.iter_mut().skip(axis).step_by(2).for_each(|row| *row -= mean);
            }
        }
    }

    /// The instrument of the unknowns `x`.
    pub(super) fn plain<'a>(&'a self, x: &'a DVector<f64>) -> Instrument<f64, Fixed<'a>> {
        let candidate = self.layout.candidate(x);
        let law = candidate.law().of(self.camera.half_centre_mm);
        Instrument { sheets: candidate.sheets(), law, focus: candidate.focus(|_, s| s) }
    }

    /// The same with a seed for every derivative.
    fn seeded<'a>(&'a self, x: &'a DVector<f64>) -> Instrument<Partial, Seeded<'a>> {
        let candidate = self.layout.candidate(x);
        let [front, back] = candidate.sheets();
        let law = LawOf { numbers: candidate.seeded_law(), ..self.layout.law.of(self.camera.half_centre_mm) };
        let focus = candidate.focus(|_, s| Partial::variable(s, FOCUS_SEED));
        Instrument { sheets: [Seeded(front, 0), Seeded(back, 3)], law, focus }
    }

    /// The same along a line.
    fn moving<'a>(&'a self, x: &'a DVector<f64>, along: &'a DVector<f64>) -> Instrument<Taylor, Moving<'a>> {
        let (here, rates) = (self.layout.candidate(x), self.layout.candidate(along));
        let sheets = [0, 1].map(|k| Moving(here.sheets()[k], rates.sheets()[k].c));
        let numbers = here.moving_law(rates.others());
        let law = LawOf { numbers, ..self.layout.law.of(self.camera.half_centre_mm) };
        Instrument { sheets, law, focus: here.focus(|k, s| Taylor([s, rates.others()[k], 0.0])) }
    }

    /// The derivatives of one residual by all unknowns, from those by its seeds.
    fn slopes(&self, row: &Partial, functions: &[Vec<[f64; 3]>; 2], mut put: impl FnMut(usize, f64)) {
        let [front, back] = functions;
        let by = |seed: usize, f: &[f64; 3]| row.by[seed] * f[0] + row.by[seed + 1] * f[1] + row.by[seed + 2] * f[2];
        front.iter().enumerate().for_each(|(k, f)| put(k, by(0, f)));
        back.iter().enumerate().for_each(|(k, f)| put(front.len() + k, by(3, f)));
        let free = self.layout.free.len();
        (0..free).for_each(|k| put(self.layout.law_start() + k, row.by[LAW_SEED + k]));
        if self.layout.focus.is_some() {
            put(self.layout.law_start() + free, row.by[FOCUS_SEED]);
        }
    }
}

impl Merit for LawMerit {
    fn residuals(&self, x: &DVector<f64>) -> Option<DVector<f64>> {
        let mut all = Vec::with_capacity(self.rows());
        self.visit(&self.plain(x), |rows, _| all.extend_from_slice(rows))?;
        self.about_middle(&mut all);
        Some(DVector::from_vec(all))
    }

    fn jacobian(&self, x: &DVector<f64>) -> Option<(DVector<f64>, DMatrix<f64>)> {
        let mut residuals = Vec::with_capacity(self.rows());
        let mut slopes = DMatrix::zeros(self.rows(), self.layout.len());
        let [front, back] = &self.layout.bases;
        self.visit(&self.seeded(x), |rows, GlassPassage { front_mm, back_mm, .. }| {
            let functions = [(front, front_mm), (back, back_mm)].map(|(b, p)| b.functions(p[0], p[1]).collect());
            for row in rows {
                let i = residuals.len();
                self.slopes(row, &functions, |k, slope| slopes[(i, k)] = slope);
                residuals.push(row.value);
            }
        })?;
        self.about_middle(&mut residuals);
        slopes.column_iter_mut().for_each(|mut column| self.about_middle(column.as_mut_slice()));
        Some((DVector::from_vec(residuals), slopes))
    }

    fn bend(&self, x: &DVector<f64>, direction: &DVector<f64>) -> Option<DVector<f64>> {
        let mut all = Vec::with_capacity(self.rows());
        self.visit(&self.moving(x, direction), |rows, _| all.extend(rows.iter().map(|row| 2.0 * row.0[2])))?;
        self.about_middle(&mut all);
        Some(DVector::from_vec(all))
    }
}
