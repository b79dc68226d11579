//! Grid sag: exact values and derivatives, and the same prism when it is read back.

use super::*;
use biprism::io::point_cloud::read_points;
use biprism::surface::face::Face;
use biprism::system::Side;
use glam::DVec2;
use std::fs;

/// The header of a file, and its points.
fn grid(path: &Path) -> (Vec<f64>, Vec<Vec<f64>>) {
    let text = fs::read_to_string(path).expect("written");
    let numbers = |line: &str| line.split(' ').map(|v| v.parse().expect("a number")).collect::<Vec<f64>>();
    (numbers(text.lines().next().expect("a header")), text.lines().skip(1).map(numbers).collect())
}

/// Every point lies on the surface, with its slopes and twist, where the manual says that it is: rows go down from +y, which is -y
/// of the prism.
#[test]
fn points_have_the_sag_and_the_derivatives_of_the_surface() {
    let folder = tempfile::tempdir().expect("a folder");
    for name in ["prism_flat", "prism_epipolar", "prism_revolved"] {
        let found = exported(name, "zemax-grid", folder.path(), &[]);
        let system = built(&case(name));
        for (k, face) in Face::ALL.into_iter().enumerate() {
            let surface = system.prism().expect("it has one").surface(Side::Right, face);
            let figures = &found["files"][k];
            let vertex = number(&figures["vertex_mm"]);
            let (header, points) = grid(&folder.path().join(["front.dat", "back.dat"][k]));
            let [nx, ny, delx, dely, unit, xdec, ydec] = header[..] else { panic!("{header:?}") };
            assert_eq!((unit, points.len()), (0.0, (nx * ny) as usize));
            let mut count = 0;
            for (k, point) in points.iter().enumerate() {
                let [z, dx, dy, dxy, nodata] = point[..] else { panic!("{point:?}") };
                if nodata == 1.0 {
                    continue;
                }
                count += 1;
                let x = xdec + ((k % nx as usize) as f64 - 0.5 * (nx - 1.0)) * delx;
                let y = -(ydec + (0.5 * (ny - 1.0) - (k / nx as usize) as f64) * dely);
                assert!((vertex + z - surface.height_mm(x, y)).abs() < 1e-12, "{name} {face:?} {k}");
                // Differences of heights of 80 mm: rounding of 1e-14 mm over the step, and a third derivative of some 1e-3.
                let h = 1e-4;
                let height = |a: f64, b: f64| surface.jet(x + a * h, y - b * h).map(|jet| jet.value);
                let (Some(e), Some(w), Some(n), Some(s)) =
                    (height(1.0, 0.0), height(-1.0, 0.0), height(0.0, 1.0), height(0.0, -1.0))
                else {
                    continue;
                };
                assert!(
                    (dx - (e - w) / (2.0 * h)).abs() < 1e-9 && (dy - (n - s) / (2.0 * h)).abs() < 1e-9,
                    "{name} {k}"
                );
                let slope = |b: f64| surface.jet(x, y - b * h).map_or(f64::NAN, |jet| jet.dx);
                assert!((dxy - (slope(1.0) - slope(-1.0)) / (2.0 * h)).abs() < 1e-8, "{name} {face:?} {k}");
            }
            assert_eq!(number(&figures["points"]), f64::from(count));

            // Read back, a point is the surface's, bit for bit.
            let read = read_points(&folder.path().join(["front.dat", "back.dat"][k]), face).expect("it is read");
            assert_eq!(read.len(), count as usize);
            for p in read {
                let jet = surface.jet(p.x, -p.y).expect("it is there");
                assert_eq!((p.z + vertex).to_bits(), jet.value.to_bits(), "{name} {face:?} {p}");
            }
            assert!(number(&figures["interpolation_mm"]) <= 1e-8);
        }
    }
}

/// The prism.toml beside the grids reads them, and the prism is the same, to what its polynomials leave.
#[test]
fn a_grid_that_is_read_back_is_the_same_prism() {
    let folder = tempfile::tempdir().expect("a folder");
    // Of polynomials nothing is left but rounding: that of 80 mm over steps of 0.6 mm, times ten for a fit, turns rays by 2e-13, and
    // the board is 900 mm behind. A polynomial of degree 12 is to follow a surface of revolution to 1e-9 rad.
    for (name, most_mm) in [("prism_epipolar", 2e-9), ("prism_revolved", 1e-6)] {
        exported(name, "zemax-grid", folder.path(), &[]);
        let prism = fs::read_to_string(folder.path().join("prism.toml")).expect("written");
        let (own, again) = (built(&case(name)), built(&with_prism(name, &prism, folder.path())));
        let mut worst = 0.0f64;
        for k in 0..200 {
            let even = |step: f64| (f64::from(k) * step).fract();
            let px = DVec2::new(320.0 * even(0.754_877_666), 180.0 * even(0.569_840_291));
            let (a, b) = (own.trace(px).expect("it passes"), again.trace(px).expect("it passes"));
            worst = worst.max(a.board_mm.distance(b.board_mm));
        }
        println!("{name}: {worst:e} mm on the board");
        assert!(worst < most_mm, "{name}: {worst:e}");
    }
}

/// A finer tolerance takes more points, and keeps to it.
#[test]
fn the_tolerance_chooses_the_points() {
    let folder = tempfile::tempdir().expect("a folder");
    let of = |tolerance: &str| {
        let found = exported("prism_epipolar", "zemax-grid", folder.path(), &["--tolerance-mm", tolerance]);
        let front = &found["files"][0];
        (number(&front["points"]), number(&front["interpolation_mm"]))
    };
    let ((few, coarse), (many, fine)) = (of("1e-6"), of("1e-10"));
    assert!(few < many && coarse <= 1e-6 && coarse > 1e-10 && fine <= 1e-10, "{few} {coarse} {many} {fine}");
}
