use super::super::virtual_camera::tests::{paper_camera, paper_prism};
use super::super::virtual_camera::virtual_camera;
use super::*;
use crate::scene::BiprismSpec;
use glam::DVec3;

fn paper_cloud(order: MarchOrder, step_px: f64, integrator: Integrator) -> PointGrid {
    let target = virtual_camera(&paper_camera(), &paper_prism(), 0.0).unwrap();
    march(&paper_camera(), &target, &DesignSettings { order, step_px, ..DesignSettings::default() }, integrator)
        .unwrap()
}

fn spread(cloud: &PointGrid) -> f64 {
    let [low, high] = cloud.optical_path_range_mm();
    high - low
}

#[test]
fn the_optical_path_is_the_same_at_a_million_points() {
    for order in [MarchOrder::XThenY, MarchOrder::YThenX] {
        let cloud = paper_cloud(order, 1.0, Integrator::Rk4);
        assert_eq!((cloud.columns(), cloud.rows(), cloud.len()), (961, 1081, 961 * 1081));
        // 1000 steps, each rounded to some ulp (1.4e-14 mm) of lengths of 90 mm.
        assert!(spread(&cloud) < 1e-11, "{order:?}: {:e}", spread(&cloud));
    }
}

#[test]
fn the_optical_path_converges_with_the_order_of_the_method() {
    for (integrator, order) in [(Integrator::Euler, 1.0), (Integrator::Midpoint, 2.0)] {
        // 1 and 0.5 px are one grid with one and two steps between its points.
        for pair in [[16.0, 8.0], [1.0, 0.5]] {
            let [coarse, fine] = pair.map(|step| spread(&paper_cloud(MarchOrder::XThenY, step, integrator)));
            let found = libm::log2(coarse / fine);
            assert!((found - order).abs() < 0.1, "{integrator:?}: {found}");
        }
    }
}

#[test]
fn adaptive_steps_meet_the_classical_ones() {
    let [a, b] = [Integrator::Rk4, Integrator::DormandPrince(1e-13)].map(|i| paper_cloud(MarchOrder::XThenY, 16.0, i));
    let apart = a.z_mm.iter().zip(&b.z_mm).flat_map(|(a, b)| [a[0] - b[0], a[1] - b[1]]);
    assert!(apart.fold(0.0, |m: f64, d| m.max(d.abs())) < 1e-10);
}

#[test]
fn both_orders_agree_on_the_centre_lines_only() {
    let [a, b] = [MarchOrder::XThenY, MarchOrder::YThenX].map(|order| paper_cloud(order, 8.0, Integrator::Rk4));
    let (column, row) = (a.columns() / 2, a.rows() / 2);
    for i in 0..a.columns() {
        assert!((a.at(i, row).front_mm - b.at(i, row).front_mm).length() < 1e-11);
    }
    for i in 0..a.rows() {
        assert!((a.at(column, i).back_mm - b.at(column, i).back_mm).length() < 1e-11);
    }
    // Two surfaces cannot meet three conditions: elsewhere the orders differ, and by far more than rounding.
    assert!((a.at(0, 0).front_mm - b.at(0, 0).front_mm).length() > 1e-3);
}

#[test]
fn points_lie_on_their_rays_and_mirror_in_y() {
    for order in [MarchOrder::XThenY, MarchOrder::YThenX] {
        let cloud = paper_cloud(order, 16.0, Integrator::Rk4);
        let last = cloud.rows() - 1;
        for (column, row) in [(0, 0), (3, 7), (cloud.columns() - 1, last)] {
            let p = cloud.at(column, row);
            assert_eq!(p.u_px, cloud.u_px[column]);
            assert_eq!(p.v_px, cloud.v_px[row]);
            let ray = DVec3::new((2.64 + p.u_px * 0.0055) / 35.0, p.v_px * 0.0055 / 35.0, 1.0);
            assert!((p.front_mm - ray * p.front_mm.z).length() < 1e-13);
            let mirrored = cloud.at(column, last - row);
            assert_eq!(mirrored.front_mm * DVec3::new(1.0, -1.0, 1.0), p.front_mm);
            assert_eq!(mirrored.back_mm * DVec3::new(1.0, -1.0, 1.0), p.back_mm);
        }
        assert_eq!(cloud.points().nth(cloud.columns() + 2).unwrap(), cloud.at(2, 1));
    }
}

#[test]
fn the_half_image_is_covered_for_odd_sizes_and_any_step() {
    let target = virtual_camera(&paper_camera(), &paper_prism(), 0.0).unwrap();
    for (width_px, height_px, step_px) in
        [(1919, 1079, 7.0), (1920, 1080, 1.7), (192, 108, 0.3), (37, 21, 3.0), (1, 1, 1.0)]
    {
        let camera = CameraSpec { width_px, height_px, ..paper_camera() };
        let cloud =
            march(&camera, &target, &DesignSettings { step_px, ..DesignSettings::default() }, Integrator::Rk4).unwrap();
        let corner = cloud.at(cloud.columns() - 1, 0);
        assert_eq!((corner.u_px, corner.v_px), (width_px as f64 / 4.0, -(height_px as f64) / 2.0));
        assert!(cloud.spacing_px().iter().all(|s| *s <= step_px.max(1.0) * (1.0 + 1e-12)));
        let centre = cloud.at(cloud.columns() / 2, cloud.rows() / 2);
        assert_eq!((centre.u_px, centre.v_px, centre.front_mm), (0.0, 0.0, target.front_mm));
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| paper_cloud(MarchOrder::XThenY, 8.0, Integrator::Rk4))
    };
    let one = with(1);
    for threads in [2, 5] {
        assert_eq!(with(threads), one);
    }
}

#[test]
fn a_field_too_wide_for_the_glass_is_a_problem_that_says_where_and_why() {
    // At f = 5 mm the half image's corner is 46 deg off the axis and the thin edge of the prism runs out of glass.
    let camera = CameraSpec { focal_length_mm: 5.0, ..paper_camera() };
    let prism = BiprismSpec { thickness_mm: 80.0, ..paper_prism() };
    let target = virtual_camera(&camera, &prism, 0.0).unwrap();
    let settings = DesignSettings { step_px: 8.0, ..DesignSettings::default() };
    let problem = march(&camera, &target, &settings, Integrator::Rk4).unwrap_err();
    assert!(problem.rule.contains("px from the half image's centre"), "{}", problem.rule);
    assert!(problem.rule.contains("surface"), "{}", problem.rule);
}

#[test]
fn impossible_steps_are_problems() {
    let target = virtual_camera(&paper_camera(), &paper_prism(), 0.0).unwrap();
    for step_px in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-4, 1e-300] {
        let settings = DesignSettings { step_px, ..DesignSettings::default() };
        let problem = march(&paper_camera(), &target, &settings, Integrator::Rk4).unwrap_err();
        assert!(problem.rule.contains("step_px"), "{step_px}: {}", problem.rule);
    }
    let camera = CameraSpec { width_px: 50_000, height_px: 50_000, ..paper_camera() };
    let each_pixel = DesignSettings { step_px: 1.0, ..DesignSettings::default() };
    let problem = march(&camera, &target, &each_pixel, Integrator::Rk4).unwrap_err();
    assert!(problem.rule.contains("may make 16000000"), "{}", problem.rule);
    let camera = CameraSpec { height_px: 0, ..paper_camera() };
    assert!(
        march(&camera, &target, &DesignSettings::default(), Integrator::Rk4).unwrap_err().rule.contains("1920 x 0")
    );
}
