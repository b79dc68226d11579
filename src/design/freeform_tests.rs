//! The design against the paper's Table 1, by a ray trace written for this file only: vector Snell, and surfaces met by
//! Newton's method on z - sag(x, y) along the ray. It shares no code with the simulator.

use super::*;
use crate::design::virtual_camera::tests::{paper_camera, paper_prism};
use crate::scene::{CalibrationSpec, DesignSettings, MarchOrder};
use glam::DVec3;

/// A surface z(x, y): value and gradient.
type Sag<'a> = &'a dyn Fn(f64, f64) -> (f64, f64, f64);

fn design(order: MarchOrder, degree: usize, step_px: f64) -> FreeformDesign {
    let settings = DesignSettings { order, degree, step_px, ..DesignSettings::default() };
    freeform(&DesignInput { camera: paper_camera(), prism: paper_prism(), settings, virtual_camera_z_mm: 0.0 }).unwrap()
}

/// Where the ray `origin + t direction` meets the surface, and the direction after it.
fn cross(origin: DVec3, direction: DVec3, ratio: f64, sag: Sag) -> (DVec3, DVec3) {
    let mut t = (sag(origin.x, origin.y).0 - origin.z) / direction.z;
    for _ in 0..60 {
        let p = origin + direction * t;
        let (z, zx, zy) = sag(p.x, p.y);
        t -= (p.z - z) / (direction.z - zx * direction.x - zy * direction.y);
    }
    let p = origin + direction * t;
    let (z, zx, zy) = sag(p.x, p.y);
    assert!((p.z - z).abs() < 1e-12);
    // Snell's law in vector form, n along the ray.
    let n = DVec3::new(-zx, -zy, 1.0).normalize();
    let cos = direction.dot(n);
    let cos_after = (1.0 - ratio * ratio * (1.0 - cos * cos)).sqrt();
    (p, direction * ratio + n * (cos_after - ratio * cos))
}

/// The ray of a pixel at (u, v) mm from the half image's centre behind the prism.
fn behind(camera: &VirtualCamera, front: Sag, back: Sag, u: f64, v: f64) -> (DVec3, DVec3) {
    let k = camera.index_ratio;
    let (p, inside) = cross(DVec3::ZERO, camera.outer_direction(u, v).normalize(), 1.0 / k, front);
    cross(p, inside, k, back)
}

/// Mean |H|, mean |V| in mm of the departure from the designed virtual camera in the plane z = `plane`, on a uniform grid of
/// `n` x `n` over the half image with its borders.
fn deviation(camera: &VirtualCamera, front: Sag, back: Sag, plane: f64, n: usize) -> [f64; 2] {
    let at = |i: usize, half: f64| half * (2.0 * i as f64 / (n - 1) as f64 - 1.0);
    let mut sum = [0.0; 2];
    for (i, j) in (0..n).flat_map(|j| (0..n).map(move |i| (i, j))) {
        let (u, v) = (at(i, 2.64), at(j, 2.97));
        let (p, d) = behind(camera, front, back, u, v);
        let met = p + d * ((plane - p.z) / d.z);
        let ideal = camera.centre_mm + camera.virtual_direction(u, v) * (plane - camera.centre_mm.z);
        sum[0] += (met.x - ideal.x).abs();
        sum[1] += (met.y - ideal.y).abs();
    }
    sum.map(|s| s / (n * n) as f64)
}

fn flat(camera: &VirtualCamera, plane: f64) -> [f64; 2] {
    let tan = libm::tan(camera.alpha_rad);
    let facet = |x: f64, _: f64| (78.472 + x * tan, tan, 0.0);
    let base = |_: f64, _: f64| (78.472 + 8.545, 0.0, 0.0);
    deviation(camera, &facet, &base, plane, 33)
}

fn freeform_deviation(design: &FreeformDesign, plane: f64, n: usize) -> [f64; 2] {
    let front = |x: f64, y: f64| design.front.patch.sag.gradient(x, y);
    let back = |x: f64, y: f64| design.back.patch.sag.gradient(x, y);
    deviation(&design.camera, &front, &back, plane, n)
}

/// The paper's virtual image plane: one focal length *behind* O', where the rays that leave the prism meet it when they
/// are extended backwards through O'.
const VIRTUAL_SENSOR_Z: f64 = -35.0;

fn four_decimals(value: [f64; 2]) -> [f64; 2] {
    value.map(|v| (v * 1e4).round() / 1e4)
}

#[test]
fn table_1_flat_row_is_met_in_the_plane_one_focal_length_behind_the_virtual_camera() {
    let camera = virtual_camera(&paper_camera(), &paper_prism(), 0.0).unwrap();
    assert_eq!(four_decimals(flat(&camera, VIRTUAL_SENSOR_Z)), [0.0604, 0.0936]);
    // No other plane that could be meant gives these: O' itself, an image plane before it, the ridge, the board.
    for plane in [0.0, 35.0, 78.472, 1000.0] {
        assert_ne!(four_decimals(flat(&camera, plane)), [0.0604, 0.0936]);
    }
}

#[test]
fn table_1_freeform_row_is_an_upper_bound() {
    // The paper has H 0.0154, V 0.0011 mm at points of its own choice. On the uniform grid an independent implementation
    // of the equations found 0.0034 and 0.0009.
    let design = design(MarchOrder::XThenY, 5, 1.0);
    let [h, v] = freeform_deviation(&design, VIRTUAL_SENSOR_Z, 33);
    assert!(h <= 0.0154 && v <= 0.0011);
    assert_eq!(four_decimals([h, v]), [0.0034, 0.0009]);
    // Surfaces are fitted to far less than the 1e-4 mm that the table resolves.
    assert!(design.front.max_mm < 1e-5 && design.back.max_mm < 1e-5);
    assert!(design.optical_path_spread_mm < 1e-11);
}

#[test]
fn what_is_left_belongs_to_the_equations_and_not_to_step_degree_or_grid() {
    let paper = freeform_deviation(&design(MarchOrder::XThenY, 5, 1.0), VIRTUAL_SENSOR_Z, 33);
    for (degree, step_px) in [(5, 16.0), (9, 4.0)] {
        let other = freeform_deviation(&design(MarchOrder::XThenY, degree, step_px), VIRTUAL_SENSOR_Z, 33);
        // A slope error of 6e-6 rad (degree 5, from its residual) over 122 mm would be the whole 7e-4 mm; the mean of
        // its sign-changing error is far below 1 % of 0.0034.
        assert!((0..2).all(|i| (other[i] / paper[i] - 1.0).abs() < 0.01), "{degree}: {other:?} {paper:?}");
    }
}

/// The default step of 16 px gives the prism of 2 px: Simpson's rule of 60 steps instead of 480.
#[test]
fn sixteen_pixels_a_step_are_as_good_as_two() {
    let points = |design: &FreeformDesign| {
        let front = |x: f64, y: f64| design.front.patch.sag.gradient(x, y);
        let back = |x: f64, y: f64| design.back.patch.sag.gradient(x, y);
        let at = |k: usize, half: f64| half * (k as f64 / 16.0 - 1.0);
        let pixels = (0..33 * 33).map(|k| (at(k % 33, 2.64), at(k / 33, 2.97)));
        let met = pixels.map(|(u, v)| behind(&design.camera, &front, &back, u, v));
        met.map(|(p, d)| p + d * ((1000.0 - p.z) / d.z)).collect::<Vec<_>>()
    };
    for order in [MarchOrder::XThenY, MarchOrder::YThenX] {
        let fine = points(&design(order, 5, 2.0));
        let coarse = points(&design(order, 5, DesignSettings::step_for(1920)));
        let apart = fine.iter().zip(&coarse).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
        // A pixel sees 5.5 um / 35 mm of 1000 mm. The level `standard` promises 1e-5 px. Points that count alike miss by 8e-5 px.
        let apart_px = apart / (0.0055 / 35.0 * 1000.0);
        assert!(apart_px < 1e-5, "{order:?}: {apart_px:e} px");
    }
}

#[test]
fn marching_y_first_trades_the_horizontal_residual_for_a_vertical_one() {
    let [xy, yx] = [MarchOrder::XThenY, MarchOrder::YThenX].map(|order| design(order, 5, 8.0));
    let [xy, yx] = [xy, yx].map(|d| freeform_deviation(&d, VIRTUAL_SENSOR_Z, 33));
    assert!(xy[0] > 3.0 * xy[1] && yx[1] > 3.0 * yx[0], "{xy:?} {yx:?}");
}

#[test]
fn the_centre_row_is_a_pinhole() {
    // In the plane of symmetry there are two unknowns for two conditions, and the design is exact up to its fit.
    let design = design(MarchOrder::XThenY, 9, 4.0);
    let front = |x: f64, y: f64| design.front.patch.sag.gradient(x, y);
    let back = |x: f64, y: f64| design.back.patch.sag.gradient(x, y);
    for i in -8..=8 {
        let u = 2.64 * f64::from(i) / 8.0;
        let (p, d) = behind(&design.camera, &front, &back, u, 0.0);
        let ideal = design.camera.virtual_direction(u, 0.0);
        // Residuals of degree 9 are below 1e-10 mm over 6 mm, so slopes err by less than 81 * 1e-10 / 6 (Markov's
        // inequality).
        assert!((d / d.z - ideal).length() < 2e-9, "{u}: {:e}", (d / d.z - ideal).length());
        assert!((p + d * (design.camera.centre_mm.z - p.z) / d.z - design.camera.centre_mm).length() < 2e-7);
    }
}

/// The paper's design on a sensor of few, large pixels.
pub(in crate::design) fn small_cloud() -> PointGrid {
    let camera = CameraSpec {
        position_mm: DVec3::ZERO,
        focal_length_mm: 35.0,
        width_px: 48,
        height_px: 30,
        pitch_mm: 0.0055 * 40.0,
        calibration: CalibrationSpec::default(),
    };
    let prism = BiprismSpec {
        body: GlassSpec::new(1.48, 1.0),
        ridge_distance_mm: 78.472,
        thickness_mm: 8.545,
        facet_angle_rad: None,
    };
    let settings = DesignSettings { step_px: 1.0, ..DesignSettings::default() };
    freeform(&DesignInput { camera, prism, settings, virtual_camera_z_mm: 0.0 }).unwrap().cloud
}
