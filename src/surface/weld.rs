//! Corners at one place made one corner.

use glam::DVec3;
use std::collections::BTreeMap;

/// Corners are at one place when they differ by less than this share of the largest coordinate: some roundings of f32.
const SAME: f64 = 4.0 * f32::EPSILON as f64;

/// Points and triangles of `corners`, three after three, with corners at one place made one; triangles that have two
/// corners at one place, and those without area, are dropped.
pub(crate) fn weld(corners: &[DVec3]) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let largest = corners.iter().fold(0.0f64, |most, p| most.max(p.abs().max_element()));
    let same = (SAME * largest).max(f64::MIN_POSITIVE);
    let cell = |p: DVec3| (p / (2.0 * same)).to_array().map(|v| v.floor() as i64);
    let mut cells: BTreeMap<[i64; 3], Vec<u32>> = BTreeMap::new();
    let mut points: Vec<DVec3> = Vec::new();
    let mut number = |p: DVec3| {
        // A point within reach lies in this cell or in the nearest one along each axis.
        let [low, high] = [cell(p - same), cell(p + same)];
        for x in low[0]..=high[0] {
            for y in low[1]..=high[1] {
                for z in low[2]..=high[2] {
                    let near = cells.get(&[x, y, z]).into_iter().flatten();
                    if let Some(found) = near.copied().find(|k| (points[*k as usize] - p).abs().max_element() <= same) {
                        return found;
                    }
                }
            }
        }
        points.push(p);
        cells.entry(cell(p)).or_default().push(points.len() as u32 - 1);
        points.len() as u32 - 1
    };
    let named: Vec<u32> = corners.iter().map(|p| number(*p)).collect();
    let with_area = |[a, b, c]: &[u32; 3]| {
        let [p, q, r] = [a, b, c].map(|k| points[*k as usize]);
        (q - p).cross(r - p).length_squared() > 0.0
    };
    let triangles = named.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).filter(with_area).collect();
    (points, triangles)
}
