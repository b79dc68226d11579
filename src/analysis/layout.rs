//! The layout of an instrument: where its surfaces and the ways of some rays lie, for a drawing to scale (the design paper's Fig. 6).

use crate::error::Error;
use crate::geom::Ray;
use crate::surface::face::Face;
use crate::system::{Side, System};
use glam::{DVec2, DVec3};

/// Points of a surface's outline.
const OUTLINE: usize = 65;
/// Rays along a line of a half image.
const RAYS: usize = 3;

/// The way of a ray, in the world.
#[derive(Debug, Clone, PartialEq)]
pub struct RayWay {
    /// The half of the prism that it passes, where it passes one.
    pub side: Option<Side>,
    /// From the camera over the surfaces to the board, as far as it goes, in mm.
    pub points_mm: Vec<DVec3>,
}

/// A line of a surface, in the world.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceLine {
    /// Which half.
    pub side: Side,
    /// Which face.
    pub face: Face,
    /// Its points, in mm.
    pub points_mm: Vec<DVec3>,
}

/// What is drawn of an instrument.
#[derive(Debug, Clone, PartialEq)]
pub struct InstrumentLayout {
    /// Rays of the middle row, and of the middle columns of both halves.
    pub ways: [Vec<RayWay>; 2],
    /// Lines of the surfaces in the middle plane y = 0 of the prism, and in the planes x = const of its halves' middle rays.
    pub surfaces: [Vec<SurfaceLine>; 2],
    /// The outline of the board.
    pub board_mm: [DVec3; 4],
    /// The camera's pinhole.
    pub camera_mm: DVec3,
}

/// The layout of `system`.
///
/// # Errors
/// When no ray passes the prism.
pub fn layout(system: &System) -> Result<InstrumentLayout, Error> {
    let [width, height] = system.camera().size_px().map(|n| n as f64);
    let along = |k: usize| k as f64 / (RAYS - 1) as f64;
    let inside = |share: f64| (share - 0.5) * 0.999_999 + 0.5;
    let halves = [0.0, 0.5];
    let row = halves
        .iter()
        .flat_map(|first| (0..RAYS).map(move |k| DVec2::new((first + 0.5 * inside(along(k))) * width, 0.5 * height)));
    let columns = halves
        .iter()
        .flat_map(|first| (0..RAYS).map(move |k| DVec2::new((first + 0.25) * width, inside(along(k)) * height)));
    let ways = [row.map(|px| way(system, px)).collect::<Vec<_>>(), columns.map(|px| way(system, px)).collect()];
    let surfaces = surfaces(system, &ways);
    let pattern = &system.board().pattern;
    let size = DVec2::new(pattern.columns as f64, pattern.rows as f64) * pattern.square_mm;
    let corner = |x: f64, y: f64| system.board().world(DVec2::new(x, y) * size);
    if system.prism().is_some() && surfaces.iter().all(Vec::is_empty) {
        return Err(Error::new("the drawing", "no ray passes the prism", "look at the scene with `biprism check`"));
    }
    Ok(InstrumentLayout {
        ways,
        surfaces,
        board_mm: [corner(-0.5, -0.5), corner(0.5, -0.5), corner(0.5, 0.5), corner(-0.5, 0.5)],
        camera_mm: system.camera().position_mm(),
    })
}

/// The way of the ray of `px`.
fn way(system: &System, px: DVec2) -> RayWay {
    let (path, end) = system.path(px);
    let mut points_mm = vec![system.camera().ray(px).origin];
    points_mm.extend(path.points.iter());
    let side = end.ok().map(|(ray, side)| {
        if let Ok((_, t_mm)) = system.board().intersect(&ray) {
            points_mm.push(ray.at(t_mm));
        }
        side
    });
    RayWay { side, points_mm }
}

/// The lines of all surfaces, as far as rays meet them and a tenth beyond.
fn surfaces(system: &System, ways: &[Vec<RayWay>; 2]) -> [Vec<SurfaceLine>; 2] {
    let Some(prism) = system.prism() else { return Default::default() };
    let prism_from_world = prism.prism_from_world();
    let world_from_prism = prism_from_world.inverse();
    let mut lines: [Vec<SurfaceLine>; 2] = Default::default();
    for (plane, found) in lines.iter_mut().enumerate() {
        for side in Side::ALL {
            for face in Face::ALL {
                // Find the reach of the rays on this surface, in the prism's frame.
                let of_side = |way: &&RayWay| way.side == Some(side);
                let met = |way: &RayWay| way.points_mm.get(1 + face as usize).map(|p| prism_from_world.point(*p));
                let places: Vec<DVec3> = ways[plane].iter().filter(of_side).filter_map(met).collect();
                if places.is_empty() {
                    continue;
                }
                let reach = |of: fn(&DVec3) -> f64| {
                    let low = places.iter().map(of).fold(f64::INFINITY, f64::min);
                    let high = places.iter().map(of).fold(f64::NEG_INFINITY, f64::max);
                    [low, high, 0.1 * (high - low)]
                };
                let [x, y] = [reach(|p| p.x), reach(|p| p.y)];
                let before = places.iter().map(|p| p.z).fold(f64::INFINITY, f64::min) - 1e3;
                let at = |k: usize| {
                    let share = k as f64 / (OUTLINE - 1) as f64;
                    let within = |[low, high, spare]: [f64; 3]| low - spare + share * (high - low + 2.0 * spare);
                    let place = match (plane, side) {
                        // The faces of the halves end at the ridge.
                        (0, Side::Right) => DVec2::new(within([x[0], x[1], x[2]]).max(0.0), 0.0),
                        (0, Side::Left) => DVec2::new(within([x[0], x[1], x[2]]).min(0.0), 0.0),
                        _ => DVec2::new(0.5 * (x[0] + x[1]), within(y)),
                    };
                    let down = Ray { origin: place.extend(before), direction: DVec3::Z };
                    let hit = prism.surface(side, face).intersect(&down, system.accuracy().surface_residual_mm).ok()?;
                    Some(world_from_prism.point(down.at(hit.t_mm)))
                };
                found.push(SurfaceLine { side, face, points_mm: (0..OUTLINE).filter_map(at).collect() });
            }
        }
    }
    lines
}
