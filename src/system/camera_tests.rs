use super::*;
use crate::geom::{Distortion, Pose};
use crate::scene::{CalibrationSpec, CameraSpec};

fn calibrated() -> Camera {
    let rotation = Pose::new(DVec3::ZERO, DVec3::new(0.1, -0.2, 0.3)).rotation;
    let distortion = Distortion::new([-0.3, 0.1, 0.002, -0.003, 0.02]);
    let principal_px = Some(DVec2::new(310.5, 251.25));
    let calibration = CalibrationSpec { principal_px, rotation, distortion, focal_ratio: 1.01 };
    let position_mm = DVec3::new(1.0, 2.0, -3.0);
    let (width_px, height_px) = (640, 480);
    Camera::new(
        &CameraSpec { position_mm, focal_length_mm: 6.0, width_px, height_px, pitch_mm: 0.01, calibration },
        None,
    )
}

/// The focal length and the aperture of a lens in focus at 400 mm.
fn lens() -> ThinLens {
    ThinLens::new(1.4, 400.0, crate::effect::thin_lens::Aperture::Circle, 6.0)
}

#[test]
fn packets_of_a_calibrated_camera_have_the_bits_of_single_rays() {
    for camera in [calibrated(), calibrated().through(&lens(), DVec2::new(1.0, -0.5)), calibrated().sampled(3)] {
        let px = |k: usize| DVec2::new(13.25 + 150.0 * k as f64, 470.5 - 111.0 * k as f64);
        let rays = camera.rays([Lanes::of(|k| px(k).x), Lanes::of(|k| px(k).y)]);
        for k in 0..LANES {
            let (own, origin, to) = (camera.ray(px(k)), rays.origin, rays.direction);
            assert_eq!(own.origin, DVec3::new(origin.x.0[k], origin.y.0[k], origin.z.0[k]));
            assert_eq!(own.direction, DVec3::new(to.x.0[k], to.y.0[k], to.z.0[k]));
        }
    }
}

/// Finer pixels, a window and a frame are other names of the same places.
#[test]
fn parts_of_a_calibrated_camera_see_what_it_sees() {
    let camera = calibrated();
    for px in [DVec2::new(0.5, 0.5), DVec2::new(600.25, 33.0), DVec2::new(319.9, 479.5)] {
        let same = |other: &Camera, there: DVec2| {
            let (a, b) = (camera.ray(px), other.ray(there));
            assert!((a.direction - b.direction).length() < 1e-15 && camera.is_right(&a) == other.is_right(&b), "{px}");
            assert!((camera.image_cos(px) - other.image_cos(there)).abs() < 1e-15, "{px}");
        };
        same(&camera.sampled(4), 4.0 * px);
        same(&camera.window([100, 200], [10, 20]), px - DVec2::new(100.0, 200.0));
        same(&camera.framed(7), px + 7.0);
        let back = camera.unrectified(camera.rectified(px)).expect("it is before the camera");
        // Some roundings of 640 px.
        assert!((back - px).length() < 2e-12, "{px} {back}");
    }
}

/// Light reaches a place of the sensor from a point of the aperture at the angle that the two make, whatever the lens does
/// before it.
#[test]
fn light_reaches_the_sensor_from_the_point_of_the_aperture() {
    let point_mm = DVec2::new(1.5, -0.7);
    let px = DVec2::new(500.5, 90.25);
    // The image is un-inverted: the sensor's place stands on the other side of the axis.
    let place_mm = -(px - DVec2::new(310.5, 251.25)) * DVec2::new(0.01, 0.01 / 1.01);
    let tangent = (place_mm - point_mm) / 6.0;
    let cos = 1.0 / (1.0 + tangent.length_squared()).sqrt();
    let found = calibrated().through(&lens(), point_mm).image_cos(px);
    assert!((found - cos).abs() < 1e-15, "{found} {cos}");
}
