//! Is what a picture is held against true of the picture's own light and lens?

use crate::instruments::built;
use biprism::analysis::view::{BoardView, see};
use biprism::optics::medium::named;
use biprism::render::{Film, render};
use biprism::scene::{self, Scene};
use biprism::system::aim::Aimer;
use biprism::system::{InLight, Side, System};
use glam::DVec2;

/// The d line of helium, in nm: that to which an index belongs where the scene says nothing else.
const D_NM: f64 = 587.5618;

/// A picture of 480 x 270 px through N-BK7 of index `index`, whose scene ends with `tables`.
fn bk7(kind: &str, index: f64, tables: &str) -> Scene {
    let text = format!(
        "name = \"t\"\n[camera]\nfocal_length_mm = 35\nwidth_px = 480\nheight_px = 270\npixel_pitch_um = 22\n\
         [prism]\nkind = \"{kind}\"\nindex = {index:?}\nglass = \"N-BK7\"\nridge_distance_mm = 78.472\n\
         thickness_mm = 8.545\nfacet_angle_deg = 8.5\n[board]\ncolumns = 21\nrows = 21\nsquare_mm = 25\n\
         position_mm = [3, 2, 1000]\n{tables}"
    );
    scene::parse(&text, "t", None).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn seen(system: &System) -> (Film, BoardView) {
    let film = render(system, &());
    let view = see(system, &film.radiance, true, &());
    (film, view)
}

/// Corners that the detector finds are those of the light that made the picture: what is left is its own error, far below
/// the 1.2 px by which this line moves them.
#[test]
fn one_line_is_true_at_that_line() {
    let glass = named("N-BK7").unwrap();
    let index = glass.index(D_NM).unwrap();
    for kind in ["flat", "freeform"] {
        let system = built(&bk7(kind, index, "[effect.dispersion]\nlines_nm = [486.1327]\n"));
        let (_, view) = seen(&system);
        for half in &view.halves {
            let error = half.detected.deviation().unwrap();
            assert!(half.detected.lattice > 30 && half.detected.wrong == Some(0), "{:?}", half.detected);
            assert!(error.rms < 1e-4, "{kind}: {} px", error.rms);
        }
    }
    // The same line as the scene's own index has the same truth, by another way.
    let blue = glass.index(486.1327).unwrap();
    let by_line = built(&bk7("flat", index, "[effect.dispersion]\nlines_nm = [486.1327]\n"));
    let by_index = built(&bk7("flat", blue, ""));
    let (by_line, by_index) = (Aimer::new(&by_line), Aimer::new(&by_index));
    for side in [Side::Left, Side::Right] {
        let board_mm = DVec2::new(30.0, -41.0);
        let [a, b] = [&by_line, &by_index].map(|aimer| aimer.aim(board_mm, side).unwrap());
        assert!(a.distance(b) < 1e-9, "{a} {b}");
    }
}

/// In light of several lines positions are the mean over instruments each of which has the index of one of them.
#[test]
fn several_lines_are_true_in_the_mean() {
    let glass = named("N-BK7").unwrap();
    let lines = "[effect.dispersion]\nlines_nm = [450, 550, 650]\npowers = [1, 2, 3]\n";
    let mixed = bk7("flat", glass.index(D_NM).unwrap(), lines);
    let system = built(&mixed);
    let shares: Vec<f64> = system.effects().dispersion.as_ref().unwrap().waves.iter().map(|wave| wave.grey()).collect();
    assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-12 && shares.len() == 3);
    let each: Vec<System> =
        [450.0, 550.0, 650.0].map(|nm| built(&bk7("flat", glass.index(nm).unwrap(), ""))).into_iter().collect();
    let mean = |of: &dyn Fn(&System) -> DVec2| -> DVec2 {
        shares.iter().zip(&each).map(|(share, system)| of(system) * *share).sum()
    };

    // Board to pixel, pixel to board, and the rays behind the prism.
    let (aimer, light) = (Aimer::new(&system), InLight::new(&system));
    for (px, side) in [(DVec2::new(380.5, 100.5), Side::Right), (DVec2::new(100.5, 33.0), Side::Left)] {
        let board_mm = light.trace(px).unwrap().board_mm;
        assert!(board_mm.distance(mean(&|one| one.trace(px).unwrap().board_mm)) < 1e-9);
        let aimed = aimer.aim(board_mm, side).unwrap();
        assert!(aimed.distance(mean(&|one| Aimer::new(one).aim(board_mm, side).unwrap())) < 1e-8);
        let ray = light.exit_ray_through(px, side).unwrap();
        let (met, _) = system.board().intersect(&ray).unwrap();
        assert!(met.distance(board_mm) < 1e-9, "{met} {board_mm}");
        let (path, end) = light.path(px);
        assert_eq!(path.points.len(), 2);
        assert!(end.unwrap().0.direction.distance(ray.direction) < 1e-12);
    }

    // The truth layers of the picture, to the rounding of f32 at 200 mm.
    let film = render(&system, &());
    let truth = film.board_mm.unwrap();
    for (i, j) in [(380, 100), (100, 33), (470, 260)] {
        let px = DVec2::new(i as f64 + 0.5, j as f64 + 0.5);
        let stored = truth.get(i, j);
        let wanted = mean(&|one| one.trace(px).unwrap().board_mm);
        assert!(DVec2::new(stored[0].into(), stored[1].into()).distance(wanted) < 2e-5, "{stored:?} {wanted}");
    }
}

/// Every corner in a telecentric picture is known, through a prism as it should be, as it was made, and turned.
#[test]
fn telecentric_corners_are_known() {
    for (what, made) in
        [("plain", ""), ("made", "[effect.manufacture.front]\ntilt_deg = [0.1, 0.05, 0]\n"), ("rolled", "tilt")]
    {
        let tilt = if made == "tilt" { "tilt_deg = [2, -3, 4]\n" } else { "" };
        let effect = if made == "tilt" { "" } else { made };
        let text = format!(
            "name = \"t\"\n[camera]\nfocal_length_mm = 35\nwidth_px = 480\nheight_px = 270\npixel_pitch_um = 22\n\
             [prism]\nkind = \"flat\"\nindex = 1.48\nridge_distance_mm = 78.472\nthickness_mm = 8.545\n\
             facet_angle_deg = 8\n[board]\ncolumns = 31\nrows = 21\nsquare_mm = 1\nposition_mm = [0.2, 0.1, 200]\n{tilt}\
             [effect.telecentric]\nmagnification = 0.55\nna = 0\nfocus_mm = 190\n{effect}"
        );
        let scene = scene::parse(&text, "t", None).unwrap_or_else(|error| panic!("{error}\n{text}"));
        let (_, view) = seen(&built(&scene));
        for half in &view.halves {
            assert_eq!(half.detected.wrong, Some(0), "{what}");
            assert!(half.detected.found > 30, "{what}: {:?}", half.detected);
            assert!(half.detected.deviation().unwrap().rms < 1e-3, "{what}");
        }
    }
}
