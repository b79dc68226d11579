//! The two sheets of a closed body, as CAD programs export a prism: the lower one, towards the camera, and the upper one.

use super::mesh::{Mesh, Normals, Triangles};
use super::normals::normals_with_creases;
use super::weld::weld;
use crate::geom::Ray;
use glam::{DVec2, DVec3};
use std::collections::BTreeMap;

/// Triangles whose normals have a z below this are side walls: they stand within 6 deg of upright.
const WALL: f64 = 0.1;
/// A body whose sheet reaches less than this share of one side's width to the other lies on the one side.
const ONE_SIDED: f64 = 0.25;
/// Heights of one sheet over one place differ by less than this share of the body's extent.
const SAME_HEIGHT: f64 = 1e-6;
/// A sheet continues beyond the ridge by this share of its width.
const BEYOND: f64 = 0.05;
/// Normals of the two sides of x = 0 that differ by more than this, in rad (1 deg), belong to a ridge.
const RIDGE_RAD: f64 = 0.017_5;

/// The surfaces of a prism that is given as a closed body.
#[derive(Debug, Clone, PartialEq)]
pub struct Sheets {
    /// Front and back of the right half; of the left half too where the body spans both.
    pub right: [Triangles; 2],
    /// Front and back of the left half, where the body spans both halves.
    pub left: Option<[Triangles; 2]>,
    /// Triangles of the whole front, the whole back, and the side walls.
    pub counts: [usize; 3],
    /// Smallest and largest z of front and back, in mm.
    pub heights_mm: [[f64; 2]; 2],
}

/// A sheet: points and the triangles over them.
#[derive(Debug, Clone, Default)]
struct Sheet {
    points: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
}

/// Parts the triangles of a closed body: those that a vertical line meets first are the front, those that it meets last
/// the back, whatever their winding; side walls are dropped. A body that spans both halves is cut at x = 0: each half has
/// its own front, which continues straight a little way beyond the ridge, and both have the whole back.
///
/// # Errors
/// A rule and a next step, where the triangles are no body of two sheets.
pub fn sheets(points_mm: &[DVec3], triangles: &[[u32; 3]]) -> Result<Sheets, (String, String)> {
    let corners: Vec<DVec3> = triangles.iter().flatten().map(|k| points_mm[*k as usize]).collect();
    let (points, triangles) = weld(&corners);
    let [front, back] = parted(&points, &triangles)?;
    let counts = [front.triangles.len(), back.triangles.len()];
    let heights_mm = [&front, &back].map(|sheet| {
        sheet.points.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], p| [low.min(p.z), high.max(p.z)])
    });
    let (low, high) = front.points.iter().fold((0.0f64, 0.0f64), |(a, b), p| (a.min(p.x), b.max(p.x)));
    let spans = -low > ONE_SIDED * high && high > ONE_SIDED * -low;
    // The mirror image of a half is glass as well: rays that cross x = 0 inside meet its back.
    let back = if spans { back } else { mirrored_too(&back) };
    let halves = |sign: f64| -> Result<[Triangles; 2], (String, String)> {
        let half = if spans { half_of(&front, sign) } else { front.clone() };
        Ok([continued(finished(&half)?, sign), whole(&back)?])
    };
    let left = if spans { Some(halves(-1.0)?) } else { None };
    let walls = triangles.len() - counts[0] - counts[1];
    Ok(Sheets { right: halves(1.0)?, left, counts: [counts[0], counts[1], walls], heights_mm })
}

/// Whether triangles close a volume: every edge belongs to two of them.
pub(crate) fn is_closed(points_mm: &[DVec3], triangles: &[[u32; 3]]) -> bool {
    let corners: Vec<DVec3> = triangles.iter().flatten().map(|k| points_mm[*k as usize]).collect();
    let (_, triangles) = weld(&corners);
    let mut edges: BTreeMap<(u32, u32), usize> = BTreeMap::new();
    for [a, b, c] in &triangles {
        for (p, q) in [(a, b), (b, c), (c, a)] {
            *edges.entry((*p.min(q), *p.max(q))).or_default() += 1;
        }
    }
    !edges.is_empty() && edges.values().all(|count| *count == 2)
}

/// The lower and the upper sheet.
fn parted(points: &[DVec3], triangles: &[[u32; 3]]) -> Result<[Sheet; 2], (String, String)> {
    let corners = |t: &[u32; 3]| t.map(|k| points[k as usize]);
    let upright = |t: &&[u32; 3]| {
        let [a, b, c] = corners(t);
        (b - a).cross(c - a).normalize_or_zero().z.abs() < WALL
    };
    let lying: Vec<[u32; 3]> = triangles.iter().filter(|t| !upright(t)).copied().collect();
    let help = "give a closed body of glass with z from the camera to the board, or `front` and `back` in files of \
                their own";
    if lying.is_empty() {
        return Err(("the body has no surface across z, side walls only".to_owned(), help.to_owned()));
    }
    let (min, max) = points.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(a, b), p| (a.min(*p), b.max(*p)));
    let same = SAME_HEIGHT * (max - min).max_element();
    let own =
        Triangles { points_mm: points.to_vec(), point_normals: vec![DVec3::Z; points.len()], triangles: lying.clone() };
    let mesh = Mesh::new(own, Normals::Flat);
    let mut parts: [Vec<[u32; 3]>; 2] = Default::default();
    for triangle in lying {
        let [a, b, c] = corners(&triangle);
        let middle = (a + b + c) / 3.0;
        let met = |z: f64, direction: DVec3| {
            let ray = Ray { origin: DVec3::new(middle.x, middle.y, z), direction };
            mesh.intersect(&ray).map_or(middle.z, |met| ray.at(met.t_mm).z)
        };
        let (low, high) = (met(min.z - 1.0, DVec3::Z), met(max.z + 1.0, -DVec3::Z));
        let which = match ((middle.z - low).abs() <= same, (middle.z - high).abs() <= same) {
            (true, false) => 0,
            (false, true) => 1,
            (true, true) => {
                let rule = format!(
                    "the body has one sheet only over ({:.4}, {:.4}) mm, at z = {:.4}: it is open",
                    middle.x, middle.y, middle.z
                );
                return Err((rule, help.to_owned()));
            }
            (false, false) => {
                let rule = format!(
                    "the body has more than two sheets over ({:.4}, {:.4}) mm: one at z = {:.4} between {low:.4} and \
                     {high:.4}",
                    middle.x, middle.y, middle.z
                );
                let help =
                    "leave out holes, undercuts and mounts: light goes in by the lowest sheet and out by the highest";
                return Err((rule, help.to_owned()));
            }
        };
        parts[which].push(triangle);
    }
    Ok(parts.map(|triangles| Sheet { points: points.to_vec(), triangles }.compact()))
}

impl Sheet {
    /// The sheet without points that no triangle has.
    fn compact(&self) -> Self {
        let mut names: BTreeMap<u32, u32> = BTreeMap::new();
        let mut points = Vec::new();
        let mut name = |k: u32| {
            *names.entry(k).or_insert_with(|| {
                points.push(self.points[k as usize]);
                points.len() as u32 - 1
            })
        };
        let triangles = self.triangles.iter().map(|t| t.map(&mut name)).collect();
        Self { points, triangles }
    }
}

/// The part of a sheet with sign x >= 0; triangles across x = 0 are cut.
fn half_of(sheet: &Sheet, sign: f64) -> Sheet {
    let width = sheet.points.iter().fold(0.0f64, |most, p| most.max(p.x.abs()));
    // A point that is as good as on the ridge is put there.
    let mut points: Vec<DVec3> = sheet
        .points
        .iter()
        .map(|p| if p.x.abs() <= SAME_HEIGHT * width { DVec3::new(0.0, p.y, p.z) } else { *p })
        .collect();
    let mut cuts: BTreeMap<(u32, u32), u32> = BTreeMap::new();
    let mut triangles = Vec::new();
    for triangle in &sheet.triangles {
        let mut kept: Vec<u32> = Vec::new();
        for k in 0..3 {
            let (here, next) = (triangle[k], triangle[(k + 1) % 3]);
            let (a, b) = (points[here as usize], points[next as usize]);
            if sign * a.x >= 0.0 {
                kept.push(here);
            }
            if a.x * b.x < 0.0 {
                // From the lower number to the higher, so that both triangles of an edge cut it at one place.
                let edge = (here.min(next), here.max(next));
                kept.push(*cuts.entry(edge).or_insert_with(|| {
                    let [p, q] = [edge.0, edge.1].map(|k| points[k as usize]);
                    let cut = p + (q - p) * (p.x / (p.x - q.x));
                    points.push(DVec3::new(0.0, cut.y, cut.z));
                    points.len() as u32 - 1
                }));
            }
        }
        let beside = kept.iter().any(|k| points[*k as usize].x != 0.0);
        for k in 2..kept.len() {
            if beside {
                triangles.push([kept[0], kept[k - 1], kept[k]]);
            }
        }
    }
    Sheet { points, triangles }.compact()
}

/// The right part of a sheet and its mirror image.
fn mirrored_too(sheet: &Sheet) -> Sheet {
    let right = half_of(sheet, 1.0);
    let image = |k: u32| right.points[k as usize] * DVec3::new(-1.0, 1.0, 1.0);
    let both = right.triangles.iter().flat_map(|[a, b, c]| {
        let own = [a, b, c].map(|k| right.points[*k as usize]);
        own.into_iter().chain([image(*a), image(*c), image(*b)])
    });
    let (points, triangles) = weld(&both.collect::<Vec<_>>());
    Sheet { points, triangles }
}

/// A sheet with its normals, parted at its creases.
fn finished(sheet: &Sheet) -> Result<Triangles, (String, String)> {
    let Sheet { points: mut points_mm, mut triangles } = sheet.clone();
    let point_normals = normals_with_creases(&mut points_mm, &mut triangles).map_err(|k| {
        let rule = format!("the body has no normal at {} mm: its sheet folds back there", sheet.points[k]);
        (rule, "give a body whose front and back are graphs z(x, y)".to_owned())
    })?;
    Ok(Triangles { points_mm, point_normals, triangles })
}

/// The whole back, which both halves share: in two parts with normals of their own where it has a ridge at x = 0.
fn whole(back: &Sheet) -> Result<Triangles, (String, String)> {
    let [left, right] = [-1.0, 1.0].map(|sign| half_of(back, sign));
    if left.triangles.is_empty() || right.triangles.is_empty() {
        return finished(back);
    }
    let [left, right] = [finished(&left)?, finished(&right)?];
    let at_zero = |half: &Triangles| -> BTreeMap<[u64; 2], DVec3> {
        let both = half.points_mm.iter().zip(&half.point_normals);
        both.filter(|(p, _)| p.x == 0.0).map(|(p, n)| ([p.y.to_bits(), p.z.to_bits()], *n)).collect()
    };
    let (a, b) = (at_zero(&left), at_zero(&right));
    let turn = a.iter().filter_map(|(at, n)| Some(n.angle_between(*b.get(at)?))).fold(0.0, f64::max);
    if turn < RIDGE_RAD {
        return finished(back);
    }
    let first = left.points_mm.len() as u32;
    let mut both = left;
    both.points_mm.extend(right.points_mm);
    both.point_normals.extend(right.point_normals);
    both.triangles.extend(right.triangles.iter().map(|t| t.map(|k| k + first)));
    Ok(both)
}

/// A front with a strip beyond its border at x = 0, straight on from there, so that rays are followed beyond the ridge as
/// if the half went on.
fn continued(mut front: Triangles, sign: f64) -> Triangles {
    let width = front.points_mm.iter().fold(0.0f64, |most, p| most.max(sign * p.x));
    let mut edges: BTreeMap<(u32, u32), usize> = BTreeMap::new();
    let at_zero = |k: u32| front.points_mm[k as usize].x == 0.0;
    for t in &front.triangles {
        for (p, q) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
            if at_zero(p) && at_zero(q) {
                *edges.entry((p.min(q), p.max(q))).or_default() += 1;
            }
        }
    }
    let step = DVec2::new(-sign * BEYOND * width, 0.0);
    let mut beyond: BTreeMap<u32, u32> = BTreeMap::new();
    for ((a, b), _) in edges.into_iter().filter(|(_, count)| *count == 1) {
        let [c, d] = [a, b].map(|k| {
            *beyond.entry(k).or_insert_with(|| {
                let (p, n) = (front.points_mm[k as usize], front.point_normals[k as usize]);
                let rise = -n.truncate().dot(step) / n.z;
                front.points_mm.push(p + step.extend(rise));
                front.point_normals.push(n);
                front.points_mm.len() as u32 - 1
            })
        });
        front.triangles.extend([[a, b, d], [a, d, c]]);
    }
    front
}
