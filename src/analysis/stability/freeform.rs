//! Freeform surfaces: several crossings, folds, high degrees, clouds that determine too little, and the solver's budget.

use super::case::{Case, ErrorUnit};
use super::scenes::{BOARD, FREEFORM, FULL, TRACE_PX, built, in_px, places, scene};
use super::tables::{self, number, rows};
use super::tally::{CaseOutcome, Tally, against};
use crate::design::fit::fit;
use crate::geom::{Ray, Rect};
use crate::num::poly2::Poly2;
use crate::optics::fate::Fate;
use crate::scene::{PolynomialPatch, PrismSpec};
use crate::surface::shape::{PolynomialSurface, Surface};
use crate::system::aim::Aimer;
use crate::system::{Side, System};
use glam::{DVec2, DVec3};

pub(super) const CASES: &[Case] = &[
    Case {
        group: "freeform",
        name: "the first of several crossings",
        hard: "wavy, tangent and cancelling sheets up to degree 15, rays along, aslant and backwards, crossings 1e-5 mm \
               apart, coefficients of 8e7 that cancel to 10",
        property: "the first crossing against the 50-digit table, as a gap along z less what the coefficients' own \
                   rounding explains; a ray that rounding leaves undecided is given up by name",
        unit: ErrorUnit::Mm,
        bound: 2e-12,
        why: "the residual asked for is 1e-12 mm, and the table's place is rounded to an f64",
        run: crossings,
    },
    Case {
        group: "freeform",
        name: "the paper's polynomial prism",
        hard: "corners, seam and centre of the field",
        property: "board positions against the 50-digit table",
        unit: ErrorUnit::Px,
        bound: 2.0 * TRACE_PX,
        why: "as the flat prism, and as much again for the polynomials' own rounding",
        run: paper_polynomial,
    },
    Case {
        group: "freeform",
        name: "fold-over of the map",
        hard: "a lens so strong that a board point is seen by several pixels or by none",
        property: "a pixel found for a board point sees that point, or none is found and the fate says so",
        unit: ErrorUnit::Px,
        bound: 1e-6,
        why: "the largest step that the search may leave",
        run: fold,
    },
    Case {
        group: "freeform",
        name: "degree 15",
        hard: "136 terms, designed and traced",
        property: "aiming undoes looking, and no ray is given up",
        unit: ErrorUnit::Px,
        bound: 1e-9,
        why: "rounding of 72 terms on each surface, weighed by the focal length in px, there and back",
        run: degree_15,
    },
    Case {
        group: "freeform",
        name: "fit from points to pixels",
        hard: "the paper's surfaces as 41 x 41 points each, fitted again",
        property: "board positions through the fitted prism are those through the prism that the points came from",
        unit: ErrorUnit::Px,
        bound: 1e-9,
        why: "z of 80 mm rounds to 7e-15 mm; a condition number of 50 over 6 mm of aperture makes 1e-13 rad of it at most, \
              6e-10 px",
        run: fitted,
    },
    Case {
        group: "freeform",
        name: "clouds that determine too little",
        hard: "3 points, near-duplicates, points on a line, on a parabola, within 1e-300 mm, noise of 1 mm",
        property: "refused by name, or fitted to within the noise",
        unit: ErrorUnit::Mm,
        bound: 1.0,
        why: "least squares leave less than the noise of 1 mm",
        run: clouds,
    },
    Case {
        group: "solver",
        name: "budget of the paper's scene",
        hard: "every third pixel of both halves, centres and corners",
        property: "no ray is given up, and every residual is that asked for",
        unit: ErrorUnit::Mm,
        bound: 1e-12,
        why: "`surface_residual_mm` of the standard accuracy",
        run: budget,
    },
];

/// The sheets of a polynomial prism.
fn patches(scene: &crate::scene::Scene) -> [PolynomialPatch; 2] {
    match &scene.prism {
        PrismSpec::Polynomial(p) => [p.front.clone(), p.back.clone()],
        _ => panic!("the scene has a polynomial prism"),
    }
}

/// Distance along z of the points on the way of `px` from their polynomials.
fn residuals(tally: &mut Tally, system: &System, patches: &[PolynomialPatch; 2], px: DVec2) {
    let (path, end) = system.path(px);
    tally.ended(&end);
    let Ok((_, side)) = end else { return };
    let own_x = |x: f64| if side == Side::Left { -x } else { x };
    for (point, patch) in path.points.iter().zip(patches) {
        tally.residual(point.z - patch.sag.value(own_x(point.x), point.y));
    }
}

fn crossings() -> CaseOutcome {
    let mut tally = Tally::default();
    let domain = Rect { min: DVec2::splat(-20.0), max: DVec2::splat(20.0) };
    for row in rows(tables::CROSSINGS) {
        let term = |packed: &str| -> (usize, usize, f64) {
            let parts: Vec<&str> = packed.split(':').collect();
            (number(parts[0]) as usize, number(parts[1]) as usize, number(parts[2]))
        };
        let terms: Vec<_> = row[1].split(' ').map(term).collect();
        let degree = terms.iter().map(|t| t.0 + t.1).max().unwrap_or(0);
        let sag = Poly2::new(degree, [0.0; 2], [1.0; 2], |m, n| {
            terms.iter().find(|t| (t.0, t.1) == (m, n)).map_or(0.0, |t| t.2)
        });
        let vector = |k: usize| DVec3::new(number(row[k]), number(row[k + 1]), number(row[k + 2]));
        let ray = Ray { origin: vector(2), direction: vector(5) };
        let place = || format!("{} from {} along {}", row[0], ray.origin, ray.direction);
        let end = Surface::Freeform(PolynomialSurface::new(&PolynomialPatch { sag: sag.clone(), domain }, false))
            .intersect(&ray, 1e-12);
        tally.ended(&end);
        // What the terms' own rounding leaves of z, at the place of the table or of the ray's origin.
        let noise = |p: DVec3| {
            let power = |base: f64, n: usize| (0..n).fold(1.0, |x, _| x * base.abs());
            let sum: f64 = terms.iter().map(|(m, n, c)| c.abs() * power(p.x, *m) * power(p.y, *n)).sum();
            4.0 * f64::EPSILON * (sum + p.length())
        };
        match (end, row[8]) {
            (Err(Fate::Missed), "missed") => tally.error(place, 0.0),
            (Ok(m), exact) if exact != "missed" => {
                let (t, speed) = (number(exact), number(row[9]));
                let gap = ((m.t_mm - t) * speed).abs();
                tally.error(place, (gap - noise(ray.at(t)) - f64::EPSILON * t * speed.abs()).max(0.0));
                let p = ray.at(m.t_mm);
                if noise(p) < 1e-13 {
                    tally.residual(p.z - sag.value(p.x, p.y));
                }
            }
            (Err(Fate::NotConverged), exact) => {
                let p = if exact == "missed" { ray.origin } else { ray.at(number(exact)) };
                tally.require(noise(p) > 1e-12, || format!("{} is given up without need", place()));
            }
            (found, exact) => tally.require(false, || format!("{}: {found:?}, and the table has {exact}", place())),
        }
    }
    tally.done()
}

fn paper_polynomial() -> CaseOutcome {
    let mut tally = Tally::default();
    let scene = scene(FULL, "", tables::PRISM, BOARD);
    let (system, patches) = (built(FULL, "", tables::PRISM, BOARD), patches(&scene));
    against(&mut tally, &system, tables::FREEFORM);
    for px in places(FULL, 2000) {
        residuals(&mut tally, &system, &patches, px);
    }
    tally.done()
}

/// A strong lens for a prism: the back bulges so much that rays cross before the board.
fn lens() -> System {
    let prism = "[prism]\nkind = \"polynomial\"\nindex = 1.5\n[prism.front]\ncentre_mm = [6.0, 0.0]\nscale_mm = [7.0, 7.0]\n\
                 domain_mm = [[-0.3, 16.0], [-9.0, 9.0]]\nterms = [[0, 0, 80.0]]\n[prism.back]\ncentre_mm = [6.0, 0.0]\n\
                 scale_mm = [7.0, 7.0]\ndomain_mm = [[-2.0, 20.0], [-12.0, 12.0]]\n\
                 terms = [[0, 0, 90.0], [2, 0, -1.2], [0, 2, -1.2], [3, 0, 0.9], [4, 0, 0.5]]";
    built([480, 270], "", prism, BOARD)
}

fn fold() -> CaseOutcome {
    let mut tally = Tally::default();
    let system = lens();
    let aimer = Aimer::new(&system);
    let (mut several, mut orientations) = (0, [0usize; 2]);
    for px in places([480, 270], 1500) {
        let Ok(footprint) = system.footprint(px) else { continue };
        let sight = footprint.sight;
        orientations[usize::from(footprint.jacobian.determinant() > 0.0)] += 1;
        let end = aimer.aim(sight.board_mm, sight.side);
        tally.ended(&end);
        if let Ok(found) = end {
            several += usize::from((found - px).length() > 1e-3);
            match system.footprint_through(found, sight.side) {
                Ok(f) => tally
                    .error(|| format!("{px}"), (f.jacobian.inverse() * (f.sight.board_mm - sight.board_mm)).length()),
                Err(fate) => tally.require(false, || format!("aimed at {found}, which sees nothing: {}", fate.name())),
            }
        }
    }
    tally.require(several > 0, || "no board point is seen by two pixels: the lens is too weak".to_owned());
    tally.require(orientations.iter().all(|n| *n > 0), || format!("the map does not fold: {orientations:?}"));
    // Points that nobody sees, and numbers that are hardly points.
    for board_mm in
        [DVec2::new(1e4, 0.0), DVec2::new(-3e3, 2e3), DVec2::splat(1e12), DVec2::splat(1e160), DVec2::splat(1e300)]
    {
        for side in Side::ALL {
            let end = aimer.aim(board_mm, side);
            tally.ended(&end);
            let right = match end {
                Err(_) => true,
                Ok(px) => system
                    .footprint_through(px, side)
                    .is_ok_and(|f| (f.jacobian.inverse() * (f.sight.board_mm - board_mm)).length() <= 1e-6),
            };
            tally.require(right, || format!("{board_mm} is aimed at with {end:?}, which does not see it"));
        }
    }
    tally.done()
}

fn degree_15() -> CaseOutcome {
    let mut tally = Tally::default();
    let prism = FREEFORM.to_owned() + "\ndegree = 15";
    let system = built(FULL, "", &prism, BOARD);
    let aimer = Aimer::new(&system);
    for px in places(FULL, 1000) {
        let end = system.trace(px);
        tally.ended(&end);
        match end.and_then(|sight| aimer.aim(sight.board_mm, sight.side)) {
            Ok(back) => tally.error(|| format!("{px}"), (back - px).length()),
            Err(fate) => tally.require(false, || format!("{px}: {}", fate.name())),
        }
    }
    tally.done()
}

fn fitted() -> CaseOutcome {
    let mut tally = Tally::default();
    let mut scene = scene(FULL, "", tables::PRISM, BOARD);
    let own = built(FULL, "", tables::PRISM, BOARD);
    let again = |patch: &PolynomialPatch| {
        let (min, size) = (patch.domain.min, patch.domain.size());
        let at = |k: usize| min + size * DVec2::new((k % 41) as f64, (k / 41) as f64) / 40.0;
        let points: Vec<DVec3> = (0..41 * 41).map(at).map(|p| p.extend(patch.sag.value(p.x, p.y))).collect();
        fit(&points, 5, Some(DVec2::from(patch.sag.centre()))).unwrap_or_else(|problem| panic!("{problem}")).patch
    };
    if let PrismSpec::Polynomial(prism) = &mut scene.prism {
        (prism.front, prism.back) = (again(&prism.front), again(&prism.back));
    }
    let other = crate::system::build(&scene).unwrap_or_else(|problem| panic!("{problem}"));
    for px in places(FULL, 1000) {
        let end = other.trace(px);
        tally.ended(&end);
        match (own.trace(px), end) {
            (Ok(a), Ok(b)) => tally.error(|| format!("{px}"), in_px(&own, px, b.board_mm - a.board_mm)),
            (a, b) => tally.require(false, || format!("{px}: {a:?} {b:?}")),
        }
    }
    tally.done()
}

fn clouds() -> CaseOutcome {
    let mut tally = Tally::default();
    let grid = |n: usize| {
        (0..n * n)
            .map(move |k| DVec2::new((k % n) as f64, (k / n) as f64) * (10.0 / (n - 1) as f64) - DVec2::new(0.0, 5.0))
    };
    let sheet = |p: DVec2| DVec3::new(p.x, p.y, 80.0 + 0.1 * p.x - 0.01 * (p.x * p.x + p.y * p.y));
    let refused: [(&str, Vec<DVec3>); 7] = [
        ("no point", Vec::new()),
        ("3 points", grid(2).take(3).map(sheet).collect()),
        ("one point 100 times", vec![sheet(DVec2::new(3.0, 2.0)); 100]),
        ("points on a line", (0..100).map(|k| sheet(DVec2::new(0.1 * f64::from(k), 0.0))).collect()),
        // On y^2 = x the powers x and y^2 are one.
        (
            "points on a parabola",
            (0..100).map(|k| 0.03 * f64::from(k)).flat_map(|y| [y, -y]).map(|y| sheet(DVec2::new(y * y, y))).collect(),
        ),
        ("near-duplicates", (0..100).map(|k| sheet(DVec2::new(1.0 + 1e-14 * f64::from(k), 2.0))).collect()),
        ("a cloud of 1e-300 mm", grid(10).map(|p| (p * 1e-301).extend(80.0)).collect()),
    ];
    for (name, points) in &refused {
        let fitted = fit(points, 5, None);
        tally.require(fitted.is_err_and(|problem| problem.rule.contains("rank")), || format!("{name} are fitted"));
    }
    // A sum of incommensurable waves is as good as noise to a polynomial.
    let noise = |k: usize| libm::sin(12.9898 * k as f64 * k as f64);
    let noisy: Vec<DVec3> = grid(40).enumerate().map(|(k, p)| sheet(p) + DVec3::Z * noise(k)).collect();
    match fit(&noisy, 5, None) {
        Ok(fitted) => {
            tally.error(|| "noisy cloud, RMS".to_owned(), fitted.rms_mm);
            tally
                .require(fitted.patch.sag.terms().all(|t| t.2.is_finite()), || "a coefficient is no number".to_owned());
        }
        Err(problem) => tally.require(false, || problem.rule),
    }
    tally.done()
}

fn budget() -> CaseOutcome {
    let mut tally = Tally::default();
    let scene = scene(FULL, "", tables::PRISM, BOARD);
    let (system, patches) = (built(FULL, "", tables::PRISM, BOARD), patches(&scene));
    for (j, i) in (0..FULL[1]).step_by(3).flat_map(|j| (0..FULL[0]).step_by(3).map(move |i| (j, i))) {
        let half = 0.5 * ((i / 3 + j / 3) % 2) as f64;
        residuals(&mut tally, &system, &patches, DVec2::new(i as f64 + half, j as f64 + half));
    }
    let outcome = tally.done();
    let given_up: usize = outcome.fates.iter().filter(|(name, _)| **name != "board").map(|(_, n)| n).sum();
    let mut tally = Tally::default();
    tally.require(given_up == 0, || format!("{given_up} rays are lost: {:?}", outcome.fates));
    tally.error(|| "residual".to_owned(), outcome.residual_mm.unwrap_or(f64::NAN));
    CaseOutcome { fates: outcome.fates, residual_mm: outcome.residual_mm, ..tally.done() }
}
