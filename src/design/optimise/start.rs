//! The start of a search: the flat prism, and what its objective leaves free.

use super::anchored::AnchoredBasis;
use super::merit::{HalfCamera, LawMerit, SpotMerit};
use super::nodes::{columns_and_rows, nodes, opening};
use super::passage::{Fixed, GlassRay, pass};
use super::unknowns::{Bounded, UnknownsLayout};
use crate::design::designed_law::{DesignedLaw, LawNumber};
use crate::design::virtual_camera::VirtualCamera;
use crate::geom::Rect;
use crate::scene::{CameraSpec, DesignSettings, Objective, Rear};
use glam::DVec2;
use nalgebra::DVector;

/// Places along each side of the half image whose rays tell where the glass is.
const BORDER: usize = 21;
/// How far the glass reaches beyond these rays, as a share of its size, on every side.
const MARGIN: f64 = 0.02;
/// Columns and rows of the half image where spots are held.
const SPOT_NODES: [usize; 2] = [7, 3];
/// How far f_x and f_y may go from f, as a share of it, and z of O' from its start, as one of the distance of the glass: as good
/// as free.
const FREEDOM: f64 = 2.0;
/// The same where spots count, which shrink with the picture.
const FREEDOM_WITH_SPOTS: f64 = 0.2;
/// How far the lens may be refocused, either way, in 1/mm: 5 dioptres.
const MOST_REFOCUS: f64 = 5e-3;

/// The flat prism, and the settings of the search.
#[derive(Debug, Clone, Copy)]
pub(super) struct Start {
    pub(super) camera: HalfCamera,
    /// Half width and half height of the half image.
    pub(super) half_mm: [f64; 2],
    pub(super) target: VirtualCamera,
    pub(super) settings: DesignSettings,
    /// The slope of the facet.
    slope: f64,
    /// Where front and back are met.
    glass: [Rect; 2],
}

/// The law that an objective asks for where its free numbers are at their starts.
fn first_law(objective: Objective, target: &VirtualCamera) -> DesignedLaw {
    DesignedLaw {
        focal_mm: [target.focal_length_mm; 2],
        centre_x_mm: 0.0,
        eye_mm: target.centre_mm.to_array(),
        toe_rad: 0.0,
        rows: objective == Objective::Epipolar,
    }
}

/// z at which an objective holds its law.
pub(super) fn depths_mm(settings: &DesignSettings) -> Vec<f64> {
    match settings.objective {
        Objective::Depth => vec![settings.goal.depth_mm],
        _ => vec![settings.goal.z_min_mm, f64::INFINITY],
    }
}

/// The numbers of the law that an objective leaves free. Those of one depth are pinned, or the prism would vanish.
fn free(settings: &DesignSettings) -> &'static [LawNumber] {
    use LawNumber::{CentreX, EyeZ, FocalX, FocalY, Toe};
    match settings.objective {
        Objective::Epipolar => &[FocalX, CentreX],
        Objective::ToedIn => &[FocalX, FocalY, CentreX, EyeZ, Toe],
        Objective::Pinhole if settings.goal.square => &[CentreX, EyeZ],
        Objective::Pinhole => &[FocalX, FocalY, CentreX, EyeZ],
        Objective::Depth | Objective::March => &[],
    }
}

impl Start {
    /// The flat prism in front of `camera` whose virtual camera is `target`; `None` where a ray of the half image does not pass.
    pub(super) fn new(camera: &CameraSpec, target: &VirtualCamera, settings: &DesignSettings) -> Option<Self> {
        let (half, half_mm) = (HalfCamera::of(camera, target), HalfCamera::half_mm(camera));
        let slope = libm::tan(target.alpha_rad);
        let mut start = Self {
            camera: half,
            half_mm,
            target: *target,
            settings: *settings,
            slope,
            glass: [Rect { min: DVec2::new(0.0, -1.0), max: DVec2::ONE }; 2],
        };
        start.glass = start.met_by_flat()?;
        Some(start)
    }

    /// Where the rays of the half image, and of the opening where spots count, meet the flat prism.
    fn met_by_flat(&self) -> Option<[Rect; 2]> {
        let bases = self.bases(1, Rear::Flat);
        let slope = bases[0].plane(self.slope);
        let front = Fixed { basis: &bases[0], c: &slope };
        self.met([&front, &Fixed { basis: &bases[1], c: &[] }])
    }

    /// Where the rays of the half image, and of the opening where spots count, meet front and back, and a little more; `None`
    /// where one does not pass.
    pub(super) fn met(&self, sheets: [&Fixed<'_>; 2]) -> Option<[Rect; 2]> {
        let mut met = [Rect { min: DVec2::INFINITY, max: DVec2::NEG_INFINITY }; 2];
        let share = |k: usize| 2.0 * k as f64 / (BORDER - 1) as f64 - 1.0;
        for (i, j) in (0..BORDER).flat_map(|i| (0..BORDER).map(move |j| (i, j))) {
            let chief: GlassRay<f64> = self.camera.ray(self.half_mm[0] * share(i), self.half_mm[1] * share(j));
            for ray in std::iter::once(chief).chain(self.opening_rays(&chief)) {
                let passage = pass(&ray, sheets, self.camera.index_ratio)?;
                for (rect, [x, y, _]) in met.iter_mut().zip([passage.front_mm, passage.back_mm]) {
                    let at = DVec2::new(x, y);
                    *rect = Rect { min: rect.min.min(at), max: rect.max.max(at) };
                }
            }
        }
        Some(met.map(|rect| {
            // Rounding apart it is symmetric in y, as the surfaces over it must be.
            let reach = rect.min.y.abs().max(rect.max.y.abs());
            let rect = Rect { min: rect.min.with_y(-reach), max: rect.max.with_y(reach) };
            let margin = MARGIN * (rect.max - rect.min);
            Rect { min: rect.min - margin, max: rect.max + margin }
        }))
    }

    /// The rays from the rim of the opening to where the lens is focused along `chief`.
    fn opening_rays(&self, chief: &GlassRay<f64>) -> Vec<GlassRay<f64>> {
        let Some(spot) = self.spot() else { return Vec::new() };
        let [x, y, z] = chief.direction;
        let through = |[px, py]: [f64; 2]| GlassRay {
            origin: [px, py, 0.0],
            direction: [x - px / spot.depth_mm, y - py / spot.depth_mm, z],
        };
        opening().map(|place| through(place.map(|p| p * spot.radius_mm))).to_vec()
    }

    /// Bases of front and back of a degree.
    fn bases(&self, degree: usize, rear: Rear) -> [AnchoredBasis; 2] {
        let [front, back] = self.glass;
        // On the plane through the ray that meets the front at its middle, and the height of the base.
        let facet_mm =
            self.target.front_mm.z + self.slope * (0.5 * (front.min.x + front.max.x) - self.target.front_mm.x);
        [
            AnchoredBasis::new(front, degree, Rear::Own, facet_mm),
            AnchoredBasis::new(back, degree, rear, self.target.back_mm.z),
        ]
    }

    fn spot(&self) -> Option<SpotMerit> {
        let goal = &self.settings.goal;
        let radius_mm = 0.5 * self.target.focal_length_mm / goal.f_number?;
        let [columns, rows] = SPOT_NODES;
        (goal.spot_weight > 0.0).then(|| SpotMerit {
            radius_mm,
            weight: goal.spot_weight,
            depth_mm: goal.depth_mm,
            nodes: nodes(self.half_mm, columns, rows),
        })
    }

    /// What is to be made small over surfaces of a degree.
    pub(super) fn merit(&self, degree: usize) -> LawMerit {
        // Bound the numbers of the law that are free.
        let law = first_law(self.settings.objective, &self.target);
        let spot = self.spot();
        let share = if spot.is_some() { FREEDOM_WITH_SPOTS } else { FREEDOM };
        let numbers = law.of::<f64>(0.0).numbers;
        let bounded = |number: LawNumber| {
            let range = match number {
                LawNumber::FocalX | LawNumber::FocalY => share * self.target.focal_length_mm,
                LawNumber::EyeZ => share * self.target.front_mm.z,
                LawNumber::CentreX => 4.0 * self.target.half_centre_mm,
                LawNumber::Toe => 2.0 * libm::tan(self.target.delta_rad),
            };
            (number, Bounded { middle: numbers[number.place()], range })
        };

        // Lay the rays out.
        let [columns, rows] = columns_and_rows(degree);
        LawMerit {
            layout: UnknownsLayout {
                bases: self.bases(degree, self.settings.goal.rear),
                law,
                free: free(&self.settings).iter().map(|number| bounded(*number)).collect(),
                focus: spot.as_ref().map(|s| Bounded { middle: 1.0 / s.depth_mm, range: MOST_REFOCUS }),
            },
            camera: self.camera,
            nodes: nodes(self.half_mm, columns, rows),
            depths_mm: depths_mm(&self.settings),
            spot,
        }
    }

    /// The unknowns of the flat prism.
    pub(super) fn unknowns(&self, layout: &UnknownsLayout) -> DVector<f64> {
        let mut x = layout.bases[0].plane(self.slope);
        x.resize(layout.len(), 0.0);
        DVector::from_vec(x)
    }
}
