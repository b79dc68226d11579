//! The freeform prism of the paper: virtual camera, march, and fitted polynomials.

use super::designed_law::DesignedLaw;
use super::fit::{SurfaceFit, fit, fit_weighted, given};
use super::march::march;
use super::optimise::{MetLaw, cloud, fitted as fitted_by_polynomials, met_law, optimised};
use super::point_grid::{PointGrid, TargetLaw};
use super::revolved::Revolved;
use super::virtual_camera::{VirtualCamera, virtual_camera};
use crate::error::Error;
use crate::num::ode::Integrator;
use crate::scene::{
    BiprismSpec, CameraSpec, DesignSettings, DesignedSurface, GlassSpec, Method, Objective, PolynomialSpec, PrismLaw,
    PrismSpec, Scene,
};
use crate::surface::shape::RevolvedPatch;
use glam::{DVec2, DVec3};

/// z of the virtual cameras in the design paper's prisms, in the prism's frame: the plane of the camera's pinhole. The
/// paper leaves it open; this choice reproduces its Table 1.
pub const VIRTUAL_CAMERA_Z_MM: f64 = 0.0;

/// z of the virtual cameras of toed-in prisms where nothing else is said, by their x: the axis at 45 deg.
const TOED_IN_SLOPE: f64 = 1.0;

/// What a freeform prism is designed from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DesignInput {
    /// The camera. Its position is not used: the pinhole is the origin of the prism's frame.
    pub camera: CameraSpec,
    /// The flat prism that the design starts from.
    pub prism: BiprismSpec,
    /// How it is designed.
    pub settings: DesignSettings,
    /// z of the virtual cameras' centres O' in the prism's frame, in mm. The paper leaves it open; 0, the plane of the
    /// camera's pinhole, reproduces its Table 1.
    pub virtual_camera_z_mm: f64,
}

/// A freeform prism, and how true it is to its equations.
#[derive(Debug, Clone, PartialEq)]
pub struct FreeformDesign {
    /// Facet angle, central ray and virtual camera of the right half.
    pub camera: VirtualCamera,
    /// The surface that faces the camera, x > 0.
    pub front: SurfaceFit,
    /// The surface that faces the scene, x > 0.
    pub back: SurfaceFit,
    /// Largest less smallest optical path over the cloud, in mm: the error of the integration.
    pub optical_path_spread_mm: f64,
    /// The points that the surfaces go through: 16 bytes each, so that a caller of many designs may want to drop them.
    pub cloud: PointGrid,
    /// The law that the rays of the right half follow, and how well; `None` of the march, which leaves kappa, and where a ray of
    /// the half image does not pass.
    pub met: Option<MetLaw>,
}

impl DesignInput {
    /// The input of a scene whose prism is flat, by the paper's settings, or freeform, by its own; `None` of another prism.
    pub fn of(scene: &Scene) -> Option<Self> {
        let (prism, settings) = match &scene.prism {
            PrismSpec::Flat(flat) => (*flat, DesignSettings::of_sensor(scene.camera.width_px)),
            PrismSpec::Freeform(flat, settings) => (*flat, *settings),
            _ => return None,
        };
        Some(Self { camera: scene.camera, prism, settings, virtual_camera_z_mm: VIRTUAL_CAMERA_Z_MM })
    }
}

impl FreeformDesign {
    /// What the halves of the picture are meant to be.
    pub fn law(&self) -> PrismLaw {
        prism_law(&self.camera, self.cloud.law)
    }

    /// The prism of the fitted surfaces, in the glass and at the place of `body`.
    pub fn prism(&self, body: GlassSpec) -> PolynomialSpec {
        PolynomialSpec { body, front: self.front.patch.clone(), back: self.back.patch.clone() }
    }
}

/// The law by which pixels of `camera` have their directions, as a scene states it.
fn prism_law(camera: &VirtualCamera, law: TargetLaw) -> PrismLaw {
    let (f, b) = (camera.focal_length_mm, camera.half_centre_mm);
    let parallel = PrismLaw {
        focal_mm: [f; 2],
        c_x_mm: 0.0,
        baseline_mm: camera.baseline_mm(),
        centre_z_mm: camera.centre_mm.z,
        tau_rad: 0.0,
        kappa_mm: 0.0,
    };
    match law {
        TargetLaw::Pinhole => parallel,
        TargetLaw::Rows => PrismLaw { kappa_mm: b, ..parallel },
        TargetLaw::Designed(law) => law.stated(b),
        TargetLaw::Stretched { axis, by } => {
            // Before the prism a direction g behind it was (I + (1/m - 1) e e^T) g: (b + u)/f and v/f are the ratios of its x and y to
            // its z, which are the products of g with p and with y, over that with q.
            let back = |v: DVec3| v + axis * (axis.dot(v) * (1.0 / by - 1.0));
            let (p, q) = (back(DVec3::X), back(DVec3::Z));
            let (along, across) = (q.normalize(), DVec3::new(q.z, 0.0, -q.x).normalize());
            PrismLaw {
                focal_mm: [f * p.dot(across) / q.length(), f / q.length()],
                c_x_mm: f * p.dot(along) / q.length() - b,
                tau_rad: libm::atan2(q.x, q.z),
                ..parallel
            }
        }
    }
}

/// The virtual camera that the objective asks for.
fn target(input: &DesignInput) -> Result<VirtualCamera, Error> {
    let settings = &input.settings;
    let stated = settings.virtual_camera_z_mm.unwrap_or(input.virtual_camera_z_mm);
    let camera = virtual_camera(&input.camera, &input.prism, stated)?;
    if settings.objective != Objective::ToedIn || settings.virtual_camera_z_mm.is_some() {
        return Ok(camera);
    }
    virtual_camera(&input.camera, &input.prism, TOED_IN_SLOPE * camera.centre_mm.x)
}

/// The surfaces of revolution of an objective that has them, front and back of the right half, which reach `spare_mm` farther to
/// all sides than the rays of the design, and what the halves of the picture are meant to be.
///
/// # Errors
/// As [`freeform`].
///
/// # Panics
/// Of [`Objective::March`], which has none.
pub fn revolved_by(input: &DesignInput, spare_mm: f64) -> Result<([RevolvedPatch; 2], PrismLaw), Error> {
    assert!(input.settings.objective != Objective::March, "the march makes no surfaces of revolution");
    let camera = target(input)?;
    // Seen from O the front is nearer than the back.
    let spare_rad = libm::atan(spare_mm / camera.front_mm.length());
    let revolved = Revolved::new(&input.camera, &camera, input.settings.objective, spare_rad)?;
    Ok((revolved.patches()?, prism_law(&camera, revolved.law())))
}

/// A freeform prism by its objective: that of the design paper, marched from the central ray of the half image, or an exact
/// one, revolved about the line from O to O'; both fitted by polynomials.
///
/// # Errors
/// A [`Error`] when the input is outside the domain of one of the steps: see [`virtual_camera()`], [`march()`] and
/// [`fit()`].
pub fn freeform(input: &DesignInput) -> Result<FreeformDesign, Error> {
    freeform_by(input, stated_integrator(&input.settings))
}

/// The integrator that settings state.
pub fn stated_integrator(settings: &DesignSettings) -> Integrator {
    match settings.method {
        Method::Euler => Integrator::Euler,
        Method::Midpoint => Integrator::Midpoint,
        Method::Rk4 => Integrator::Rk4,
    }
}

/// [`freeform`] with an integrator of choice in the place of `settings.method`: to study what each costs and buys.
///
/// # Errors
/// As [`freeform`].
pub fn freeform_by(input: &DesignInput, integrator: Integrator) -> Result<FreeformDesign, Error> {
    let settings = &input.settings;
    let Some(points) = fitted_points(input, integrator)? else {
        return by_least_squares(input, virtual_camera(&input.camera, &input.prism, input.virtual_camera_z_mm)?);
    };
    let [front, back] = points.fits(settings.degree)?;
    let DesignPoints { camera, cloud, .. } = points;
    let [shortest, longest] = cloud.optical_path_range_mm();
    let met = match settings.objective {
        Objective::March => None,
        _ => {
            let law = DesignedLaw::from(&prism_law(&camera, cloud.law));
            met_law(&input.camera, &camera, settings, [&front.patch, &back.patch], law)
        }
    };
    if let Some(met) = met.as_ref().filter(|_| settings.surface == DesignedSurface::Polynomial) {
        fitted_by_polynomials(settings, met.rms_px())?;
    }
    Ok(FreeformDesign { camera, front, back, optical_path_spread_mm: longest - shortest, cloud, met })
}

/// What the polynomials of a design are fitted to.
#[derive(Debug, Clone)]
pub struct DesignPoints {
    /// Facet angle, central ray and virtual camera of the right half.
    pub camera: VirtualCamera,
    /// The points over the half image.
    pub cloud: PointGrid,
    /// The points that are fitted, where they are others.
    others: Option<PointGrid>,
}

impl DesignPoints {
    /// The points of the front and of the back that are fitted, in mm.
    pub fn surfaces_mm(&self) -> [Vec<DVec3>; 2] {
        let fitted = self.others.as_ref().unwrap_or(&self.cloud);
        [fitted.front_mm(), fitted.back_mm()]
    }

    /// Where the polynomials of front and back have their origins, in mm: on the central ray.
    pub fn centres_mm(&self) -> [DVec2; 2] {
        [self.camera.front_mm.truncate(), self.camera.back_mm.truncate()]
    }

    /// What each point counts in the fit; none where all count alike. Over the march's grid the sum of squares stands for their
    /// integral, so that a coarse grid gives what a fine one does.
    pub fn weights(&self) -> Vec<f64> {
        if self.others.is_some() { Vec::new() } else { self.cloud.weights() }
    }

    fn fits(&self, degree: usize) -> Result<[SurfaceFit; 2], Error> {
        let ([front_mm, back_mm], [front, back]) = (self.surfaces_mm(), self.centres_mm());
        let weights = self.weights();
        if weights.is_empty() {
            return Ok([fit(&front_mm, degree, Some(front))?, fit(&back_mm, degree, Some(back))?]);
        }
        let fitted = |points_mm: &[DVec3], centre| fit_weighted(points_mm, &weights, degree, Some(centre));
        Ok([fitted(&front_mm, front)?, fitted(&back_mm, back)?])
    }
}

/// The points to which the polynomials of a design are fitted: marched, or those of surfaces of revolution; `None` of a design by
/// least squares, whose polynomials go through no points.
///
/// # Errors
/// As [`freeform`].
pub fn fitted_points(input: &DesignInput, integrator: Integrator) -> Result<Option<DesignPoints>, Error> {
    let settings = &input.settings;
    if settings.by_least_squares() {
        return Ok(None);
    }
    let camera = target(input)?;
    let (cloud, others) = match settings.objective {
        Objective::March => (march(&input.camera, &camera, settings, integrator)?, None),
        objective => {
            let revolved = Revolved::new(&input.camera, &camera, objective, 0.0)?;
            (revolved.cloud(settings)?, Some(revolved.fitted()?))
        }
    };
    Ok(Some(DesignPoints { camera, cloud, others }))
}

/// The prism of least squares, whose surfaces are polynomials from the start.
fn by_least_squares(input: &DesignInput, start: VirtualCamera) -> Result<FreeformDesign, Error> {
    let found = optimised(&input.camera, &start, &input.settings)?;
    let camera = VirtualCamera { centre_mm: found.law.eye_mm.into(), ..start };
    let patches = [&found.front, &found.back];
    let cloud = cloud(&input.camera, &camera, &input.settings, patches, found.law)?;
    let [shortest, longest] = cloud.optical_path_range_mm();
    let met = met_law(&input.camera, &camera, &input.settings, patches, found.law)
        .map(|met| MetLaw { floor_reached: found.floor_reached, ..met });
    Ok(FreeformDesign {
        camera,
        front: given(found.front, &cloud.front_mm()),
        back: given(found.back, &cloud.back_mm()),
        optical_path_spread_mm: longest - shortest,
        cloud,
        met,
    })
}

#[cfg(test)]
#[path = "freeform_tests.rs"]
pub(super) mod tests;
