//! Total reflection, grazing incidence, the ridge, and optics that vanish.

use super::case::{Case, ErrorUnit};
use super::scenes::{BOARD, FLAT, FOCAL_PX, FULL, NO_GLASS, TRACE_PX, built, in_px, places};
use super::tables::{self, number, rows};
use super::tally::{CaseOutcome, Tally};
use crate::geom::Ray;
use crate::optics::snell::refract;
use crate::render::{self, Class};
use crate::surface::shape::Surface;
use glam::{DVec2, DVec3};

pub(super) const CASES: &[Case] = &[
    Case {
        group: "total reflection",
        name: "critical angle of one surface",
        hard: "incidence at the critical angle +- 1e-3 ... 1e-16 rad and +- 1 ... 32 ulp, eta 1 + 2^-52 ... 4",
        property: "cosine of refraction and fate against the 50-digit table",
        unit: ErrorUnit::Relative,
        bound: 8.0 * f64::EPSILON,
        why: "one rounding of a difference that is taken exactly, and a square root; away from the critical angle 4 eps of \
              a difference that loses two bits",
        run: || refraction(|cos_in| cos_in >= 1e-9),
    },
    Case {
        group: "total reflection",
        name: "part of a facet beyond it",
        hard: "a prism of index 0.6 at 30 deg: the fate changes inside the picture",
        property: "along a row the fate changes once in a half, the picture is dark exactly there, and both halves agree",
        unit: ErrorUnit::Radiance,
        bound: 0.0,
        why: "a totally reflected pixel brings no light",
        run: partly_reflected,
    },
    Case {
        group: "grazing",
        name: "grazing incidence on one surface",
        hard: "cosine of incidence 1e-300 ... 1e-2",
        property: "cosine of refraction and fate against the 50-digit table",
        unit: ErrorUnit::Relative,
        bound: 8.0 * f64::EPSILON,
        why: "as at the critical angle",
        run: || refraction(|cos_in| cos_in < 1e-2),
    },
    Case {
        group: "grazing",
        name: "rays parallel to a plane",
        hard: "directions within 0 and 1e-16 ... 1e-1 of the plane, from 1e-9 ... 1e9 mm above it",
        property: "the meeting point lies on the plane, as a share of the way; exactly parallel rays miss",
        unit: ErrorUnit::Relative,
        bound: 4.0 * f64::EPSILON,
        why: "rounding of the quotient, of the product and of the sum",
        run: parallel_to_a_plane,
    },
    Case {
        group: "grazing",
        name: "edge-on board",
        hard: "a board tilted by 90 deg, and by 90 deg +- 1e-12 ... 1e-3 deg",
        property: "positions against the closed form of the tilted plane; every pixel of the picture is a number",
        unit: ErrorUnit::Px,
        bound: 1e3 * TRACE_PX,
        why: "the board stands 10 mm from the axis: y is a thousandth of the way, so its rounding counts 1e3 times",
        run: edge_on_board,
    },
    Case {
        group: "ridge",
        name: "on the ridge to the last bit",
        hard: "rays within 8 ulp of the ridge, camera and prism off the axis, ridge towards and away from the camera",
        property: "every ray passes one side, and both sides go on alike: their facets meet in the ridge",
        unit: ErrorUnit::Mm,
        bound: 1e-8,
        why: "8 ulp of 1e3 px are 1e-12 px, or 1e-13 mm on the facet; a wrong sheet would be 1e-3 mm off",
        run: on_the_ridge,
    },
    Case {
        group: "ridge",
        name: "seam inside and beside pixels",
        hard: "odd and even widths, ridge off the centre, pinhole beyond the ridge's plane",
        property: "no ray is lost, every pixel is a number within the board's radiances, mirrored scenes mirror",
        unit: ErrorUnit::Radiance,
        bound: 1e-6,
        why: "f32 of radiances up to 1; beside a cut, derivatives come from other rays",
        run: seams,
    },
    Case {
        group: "vanishing optics",
        name: "the paper's flat prism",
        hard: "corners, seam and centre of the field",
        property: "board positions against the 50-digit table",
        unit: ErrorUnit::Px,
        bound: TRACE_PX,
        why: "16 roundings of a direction, times the focal length in px",
        run: paper_flat,
    },
    Case {
        group: "vanishing optics",
        name: "prisms from nothing to extreme",
        hard: "facet angle 0, 1e-300 ... 60 deg; index ratio 1 +- 1e-16, 0.2 ... 10; thickness 1e-12 ... 900 mm; \
               in water; board from the base to 1e12 mm; ridge from 1e-6 to 1e6 mm",
        property: "board positions and fates against the 50-digit table",
        unit: ErrorUnit::Px,
        bound: 8.0 * TRACE_PX,
        why: "as the paper's prism; at the extremes the light is bent by up to 8 times as much",
        run: prisms,
    },
];

fn refraction(wanted: fn(f64) -> bool) -> CaseOutcome {
    let mut tally = Tally::default();
    for row in rows(tables::REFRACTION) {
        let [eta, x, z] = [0, 1, 2].map(|k| number(row[k]));
        if !wanted(z) {
            continue;
        }
        let place = || format!("eta {eta:?}, cos_in {z:?}");
        match (refract(DVec3::new(x, 0.0, z), DVec3::Z, eta), row[3]) {
            (None, "none") => tally.error(place, 0.0),
            (Some(out), exact) if exact != "none" => {
                let exact = number(exact);
                // 0 only for 0.
                let scale = if exact == 0.0 { f64::MIN_POSITIVE } else { exact };
                tally.error(place, (out.cos_out - exact) / scale);
                tally.require(out.direction.is_finite() && (out.direction.z >= 0.0 || z == 0.0), || {
                    format!("direction at {}", place())
                });
            }
            (found, exact) => tally.require(false, || format!("{}: {found:?}, and the table has {exact}", place())),
        }
    }
    tally.done()
}

fn partly_reflected() -> CaseOutcome {
    let mut tally = Tally::default();
    let prism = "kind = \"flat\"\nindex = 0.6\nridge_distance_mm = 78.472\nthickness_mm = 60.0\nfacet_angle_deg = 30.0";
    let film = render::render(&built([128, 72], "", prism, BOARD), &());
    let (width, height) = (film.radiance.width(), film.radiance.height());
    let dark = |i: usize, j: usize| film.class_at(i, j) == Some(Class::TotalReflection);
    let mut reflected = 0;
    for j in 0..height {
        let changes = (width / 2 + 1..width).filter(|&i| dark(i, j) != dark(i - 1, j)).count();
        tally.require(changes <= 1, || format!("row {j}: the fate changes {changes} times in a half"));
        for i in 0..width {
            reflected += usize::from(dark(i, j));
            tally.ended(&if dark(i, j) { Err(crate::optics::fate::Fate::TotalReflection) } else { Ok(()) });
            tally.require(dark(i, j) == dark(width - 1 - i, j), || format!("({i}, {j}) and its mirror image"));
            // Pixels on the border of the fate are seen in part.
            let inside = i > 0 && j > 0 && i + 1 < width && j + 1 < height;
            if inside && (0..9).all(|k| dark(i + k % 3 - 1, j + k / 3 - 1)) {
                tally.error(|| format!("({i}, {j})"), f64::from(film.radiance.get(i, j)));
            }
        }
    }
    tally.require((1..width * height).contains(&reflected), || format!("{reflected} pixels are reflected"));
    tally.done()
}

fn parallel_to_a_plane() -> CaseOutcome {
    let mut tally = Tally::default();
    let plane = Surface::Plane { point: DVec3::ZERO, normal: DVec3::Z };
    for slope in (1..=16).map(|e| libm::exp10(-f64::from(e))).chain([1e-100, 1e-300]) {
        for height in (-9..=9).map(|e| libm::exp10(f64::from(e))) {
            let ray =
                Ray { origin: DVec3::new(3.0, -2.0, -height), direction: DVec3::new(1.0, 0.0, slope).normalize() };
            match plane.intersect(&ray, 1e-12) {
                Ok(m) => {
                    let place = || format!("slope {slope:e}, height {height:e}");
                    tally.error(place, ray.at(m.t_mm).z / height);
                    tally.require(m.t_mm.is_finite(), place);
                }
                // Beyond the numbers there is no meeting.
                Err(_) => {
                    tally.require(height / slope > 1e300, || format!("missed at slope {slope:e}, height {height:e}"))
                }
            }
        }
    }
    let along = Ray { origin: DVec3::new(0.0, 0.0, -1.0), direction: DVec3::X };
    tally.require(plane.intersect(&along, 1e-12).is_err(), || "a parallel ray meets the plane".to_owned());
    let within = Ray { origin: DVec3::ZERO, direction: DVec3::X };
    tally.require(plane.intersect(&within, 1e-12).is_err(), || "a ray in the plane meets it".to_owned());
    tally.done()
}

fn edge_on_board() -> CaseOutcome {
    let mut tally = Tally::default();
    for off in [0.0f64, 1e-12, -1e-12, 1e-9, 1e-6, -1e-6, 1e-3] {
        let tilt = 90.0 + off;
        let board = format!(
            "columns = 41\nrows = 41\nsquare_mm = 10.0\nposition_mm = [0.0, 10.0, 1000.0]\ntilt_deg = [{tilt:?}, 0.0, 0.0]"
        );
        let system = built(FULL, "", NO_GLASS, &board);
        let (sin, cos) = libm::sincos(tilt.to_radians());
        for px in places(FULL, 500) {
            let t = (px - DVec2::new(960.0, 540.0)) / FOCAL_PX;
            // The plane through (0, 10, 1000) along x and (0, cos, sin): y cos(90) ... solved for the ray z (t, 1).
            let z = (1000.0 * cos - 10.0 * sin) / (cos - t.y * sin);
            let end = system.trace(px);
            tally.ended(&end);
            match end {
                Ok(sight) => {
                    // v along (0, cos, sin), from whichever of its components is the larger one.
                    let v = if sin.abs() > cos.abs() { (z - 1000.0) / sin } else { (t.y * z - 10.0) / cos };
                    tally.error(
                        || format!("{px}, tilt {tilt}"),
                        in_px(&system, px, sight.board_mm - DVec2::new(t.x * z, v)),
                    );
                }
                Err(_) => tally.require(z <= 0.0 || !z.is_finite(), || format!("{px}, tilt {tilt}: lost")),
            }
        }
        let film = render::render(&built([48, 27], "", NO_GLASS, &board), &());
        tally.require(film.radiance.data().iter().all(|r| (0.05..=0.85).contains(r)), || {
            format!("picture at tilt {tilt}")
        });
    }
    tally.done()
}

fn on_the_ridge() -> CaseOutcome {
    let mut tally = Tally::default();
    for (camera_x, prism_x) in [(0.0, 0.0), (3.7, 0.0), (-3.7, 0.0), (0.0, 1.1), (1.0 / 3.0, -0.7)] {
        for angle in [8.85, 1e-9, -5.0] {
            let camera = format!("position_mm = [{camera_x:?}, 0.0, 0.0]");
            let prism = format!("{FLAT}\nfacet_angle_deg = {angle:?}\nposition_mm = [{prism_x:?}, 0.0, 0.0]");
            let system = built(FULL, &camera, &prism, BOARD);
            let ridge = 960.0 + (prism_x - camera_x) / 78.472 * FOCAL_PX;
            for k in 0..4001i64 {
                let x = f64::from_bits((ridge.to_bits() as i64 + k % 17 - 8) as u64);
                let px = DVec2::new(x, 1080.0 * k as f64 / 4000.0);
                let (path, end) = system.path(px);
                tally.ended(&end);
                tally.require(end.is_ok(), || format!("{px} is lost"));
                if let Some(point) = path.points.first() {
                    tally.error(|| format!("{px}"), (*point - DVec3::new(prism_x, point.y, 78.472)).length());
                }
            }
        }
    }
    tally.done()
}

fn seams() -> CaseOutcome {
    let mut tally = Tally::default();
    for size in [[65, 37], [64, 36], [33, 2], [1, 9], [2, 1], [3, 3], [129, 5]] {
        for (x, z) in [(0.0, 0.0), (0.31, 0.0), (-2.0, 0.0), (30.0, 80.0), (-30.0, 80.0)] {
            let of = |x: f64| {
                let prism = format!("{FLAT}\nfacet_angle_deg = 8.85");
                built(size, &format!("position_mm = [{x:?}, 0.0, {z:?}]"), &prism, BOARD)
            };
            let film = render::render(&of(x), &());
            let twin = render::render(&of(-x), &());
            for (j, i) in (0..size[1]).flat_map(|j| (0..size[0]).map(move |i| (j, i))) {
                let place = || format!("({i}, {j}) of {size:?}, pinhole at x {x}, z {z}");
                let radiance = film.radiance.get(i, j);
                tally.require((0.0499..=0.8501).contains(&radiance), || format!("{radiance} at {}", place()));
                let seen = film.class_at(i, j).and_then(Class::side).is_some();
                tally.require(seen, || format!("{:?} at {}", film.class_at(i, j), place()));
                tally.error(place, f64::from(radiance - twin.radiance.get(size[0] - 1 - i, j)));
            }
        }
    }
    tally.done()
}

fn paper_flat() -> CaseOutcome {
    let system = built(FULL, "", FLAT, BOARD);
    let mut tally = Tally::default();
    crate::analysis::stability::tally::against(&mut tally, &system, tables::FLAT);
    tally.done()
}

fn prisms() -> CaseOutcome {
    let mut tally = Tally::default();
    for row in rows(tables::PRISMS) {
        let prism = format!(
            "kind = \"flat\"\nindex = {}\nouter_index = {}\nfacet_angle_deg = {}\nridge_distance_mm = {}\nthickness_mm = {}",
            row[0], row[1], row[2], row[3], row[4]
        );
        let board = format!(
            "columns = 41\nrows = 41\nsquare_mm = 10.0\nposition_mm = [0.0, 0.0, {0}]\n[analysis]\ndepths_mm = [{0}]",
            row[5]
        );
        let place = || row[..8].join(",");
        let text = super::scenes::text(FULL, "", &prism, &board);
        let scene = match crate::scene::parse(&text, "the catalogue of hard cases", None) {
            Ok(scene) => scene,
            // A prism through which nothing passes is refused before a ray is traced.
            Err(problem) => {
                tally.require(row[8] == "total_reflection", || format!("{}: {}", place(), problem.rule));
                continue;
            }
        };
        let system = crate::system::build(&scene).unwrap_or_else(|problem| panic!("{problem}"));
        let px = DVec2::new(number(row[6]), number(row[7]));
        let end = system.trace(px);
        tally.ended(&end);
        match end {
            Ok(sight) if row[8] == "board" => {
                let exact = DVec2::new(number(row[9]), number(row[10]));
                tally.error(place, in_px(&system, px, sight.board_mm - exact));
            }
            Ok(_) => tally.require(false, || format!("{}: seen, and the table has {}", place(), row[8])),
            Err(fate) => tally.require(fate.name() == row[8], || format!("{}: {}", place(), fate.name())),
        }
    }
    tally.done()
}
