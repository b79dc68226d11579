//! Pixels by the map of the columns that the seam passes through: those on either side of it by the map of that side, those
//! under it cut along it.

use super::band::Band;
use super::map::MapPatch;
use super::mapped::{board, edge_means, packed_taylor2};
use super::pixel::square;
use super::pixel_mean::{PackedTaylor2, Taylor2, mean_of_points};
use super::plan::Plan;
use super::row_map::RowMap;
use super::seam_map::SeamMap;
use super::work::Work;
use crate::num::simd::{Kernel, LANES, Lanes, widest};
use crate::texture::Convex;
use glam::DVec2;

/// Parts along each side of a pixel at most.
const MOST_PARTS: f64 = 64.0;
/// A polygon between the places that its corners see strays from the pixel's part by as much as the map does along two of its
/// sides at a corner, and weighs what is within by as much again.
const STRAYS: f64 = 4.0;
/// An arc takes this share of the rectangle about it.
const ARC_SHARE: f64 = 2.0 / 3.0;
/// So near to a centre, in px, the seam may be on either side of it by rounding alone.
const TIE_PX: f64 = 1e-9;

/// Renders the part of the map that lies in `band`.
pub(super) fn render(plan: &Plan, seam: &SeamMap, band: &mut Band) -> Work {
    let region = band.part_of(&seam.region);
    if region.columns.is_empty() || region.rows.is_empty() {
        return Work::default();
    }
    let sides = seam.sides.each_ref().map(|side| side.part(region.clone()));
    widest(SeamRows { plan, seam, sides, band })
}

struct SeamRows<'a, 'b, 'c> {
    plan: &'a Plan<'a>,
    seam: &'a SeamMap,
    /// The maps of both sides over the columns in the band.
    sides: [MapPatch; 2],
    band: &'b mut Band<'c>,
}

impl Kernel for SeamRows<'_, '_, '_> {
    type Out = Work;

    #[inline(always)]
    fn run(self) -> Work {
        let Self { plan, seam, sides, band } = self;
        let mut work = Work::default();
        let half = 0.5 * plan.active;
        let columns = sides[0].region.columns.clone();
        let mut listed = [Vec::new(), Vec::new()];
        let mut cut = Vec::new();
        let mut maps = [[RowMap::none(); LANES]; 2];
        for (r, j) in sides[0].region.rows.clone().enumerate() {
            if r.is_multiple_of(LANES) {
                (0..2).for_each(|k| RowMap::fill(&mut maps[k], &sides[k], j, plan.active));
            }

            // Tell the pixels of either side from those under the seam.
            let y = j as f64 + 0.5;
            let (upper, lower) = (seam.column(y - half), seam.column(y + half));
            let (from, to) = (upper.min(lower) - seam.stray_px, upper.max(lower) + seam.stray_px);
            listed.iter_mut().for_each(Vec::clear);
            cut.clear();
            for (i, x) in columns.clone().enumerate().filter(|_| !plan.truth_alone) {
                let x = x as f64 + 0.5;
                if x + half <= from {
                    listed[0].push(i as u32);
                } else if x - half >= to {
                    listed[1].push(i as u32);
                } else {
                    cut.push(i as u32);
                }
            }

            // Integrate each.
            let rows = [&maps[0][r % LANES], &maps[1][r % LANES]];
            let start = band.at(columns.start, j);
            let span = start..start + columns.len();
            let out = &mut band.radiance[span.clone()];
            for k in 0..2 {
                edge_means(plan, &sides[k], rows[k], y, out, &listed[k], &mut work);
            }
            for few in cut.chunks(LANES) {
                let at = |k: usize| columns.start as f64 + 0.5 + f64::from(few[k.min(few.len() - 1)]);
                let maps = [expansions(plan, &sides[0], rows[0], at), expansions(plan, &sides[1], rows[1], at)];
                for (k, &i) in few.iter().enumerate() {
                    let maps = [maps[0].lane(k), maps[1].lane(k)];
                    out[i as usize] = cut_pixel(plan, seam, DVec2::new(at(k), y), &maps, &mut work) as f32;
                }
            }

            // Store the ground truth: of the side on which the centre is.
            if let Some(truth) = &mut band.truth {
                // Where the seam is on a centre but for rounding, the right side is seen, as by its ray.
                let middle = seam.column(y) - TIE_PX;
                let right = columns.clone().position(|x| x as f64 + 0.5 >= middle).unwrap_or(columns.len());
                let mut seen = vec![[0.0f32; 2]; columns.len()];
                for (side, part) in [(0, 0..right), (1, right..columns.len())] {
                    board(plan, &sides[side], rows[side], &mut seen);
                    truth.board_mm[span.clone()][part.clone()].copy_from_slice(&seen[part.clone()]);
                    truth.class[span.clone()][part].fill(sides[side].class);
                }
            }
        }
        work
    }
}

/// The expansions about the centres of [`LANES`] pixels of a row, by steps of a pixel's active side.
#[inline(always)]
fn expansions(plan: &Plan, side: &MapPatch, row: &RowMap, at: impl Fn(usize) -> f64) -> PackedTaylor2 {
    let s = Lanes::of(|k| side.s(at(k)));
    packed_taylor2(side.flip, side.steps().x * plan.active, row.derivatives(0, s), row.derivatives(1, s))
}

/// The radiance of the pixel at `px`, cut along the seam, given the maps of both sides about it.
fn cut_pixel(plan: &Plan, seam: &SeamMap, px: DVec2, maps: &[Taylor2; 2], work: &mut Work) -> f64 {
    // Where a side sees one radiance all over the pixel, its share alone counts.
    let plain = maps.each_ref().map(|map| constant(plan, map));
    work.counts.cut_pixels += 1;
    work.counts.edge_pixels += u64::from(plain.iter().any(Option::is_none));

    // Divide it until map and seam are as straight in its parts as the bend allowed asks.
    let lined = maps.iter().zip(plain).filter(|(_, plain)| plain.is_none());
    let off_px = lined.map(|(map, _)| STRAYS * map.stray_px()).fold(ARC_SHARE * seam.stray_px, f64::max);
    let wanted = (off_px / seam.allowed_px).sqrt().ceil().max(1.0);
    let n = wanted.min(MOST_PARTS) as u32;
    work.counts.capped_pixels += u64::from(wanted > MOST_PARTS);
    work.bend_px = work.bend_px.max(off_px / f64::from(n * n));

    // Sum up the parts, each cut along the chord of the seam.
    let active = plan.active;
    let columns = if plain.iter().all(Option::is_some) { 1 } else { n };
    let (width, height) = (active / f64::from(columns), active / f64::from(n));
    let mut sums = [0.0; 2];
    for j in 0..n {
        let top = height * f64::from(j) - 0.5 * active;
        let [upper, lower] = [top, top + height].map(|y| seam.column(px.y + y) - px.x);
        let left = |p: DVec2| upper + (lower - upper) * ((p.y - top) / height) - p.x;
        for i in 0..columns {
            let middle = DVec2::new(width * (f64::from(i) + 0.5) - 0.5 * active, top + 0.5 * height);
            let part = Convex::new(&square(0.5).map(|corner| middle + corner * DVec2::new(width, height)));
            for (k, piece) in [part.cut(left), part.cut(|p| -left(p))].iter().enumerate() {
                let area = piece.area();
                if area > 0.0 {
                    sums[k] += area * plain[k].unwrap_or_else(|| mean(plan, &maps[k], piece.vertices()));
                }
            }
        }
    }
    (sums[0] + sums[1]) / (active * active)
}

/// The radiance that a map shows all over a pixel, if it is one.
fn constant(plan: &Plan, map: &Taylor2) -> Option<f64> {
    let stray = 0.125 * (map.dxx.abs() + 2.0 * map.dxy.abs() + map.dyy.abs());
    plan.face().constant(map.seen, 0.5 * (map.dx.abs() + map.dy.abs()) + stray)
}

/// The mean radiance over a convex part of a pixel, in px about its centre, between the places that its corners see.
fn mean(plan: &Plan, map: &Taylor2, outline: &[DVec2]) -> f64 {
    let see = |p: &DVec2| {
        let p = *p / plan.active;
        let bend = 0.5 * (map.dxx * (p.x * p.x) + map.dyy * (p.y * p.y)) + map.dxy * (p.x * p.y);
        map.seen + (map.dx * p.x + map.dy * p.y) + bend
    };
    let mut seen = [DVec2::ZERO; 8];
    seen.iter_mut().zip(outline).for_each(|(to, from)| *to = see(from));
    let (face, seen) = (plan.face(), &seen[..outline.len()]);
    face.mean_over(seen).unwrap_or_else(|| mean_of_points(&|c| face.radiance(c), seen, outline))
}

#[cfg(test)]
mod tests {
    use crate::accuracy::Accuracy;
    use crate::render::bands::picture;
    use crate::render::film::Outputs;
    use crate::render::plan::Plan;
    use crate::render::region::Region;
    use crate::render::seam_map::SeamMap;
    use crate::render::tests::{built, scene};
    use crate::system::System;

    /// A slanted and a curved seam, and the three of a solid prism, by the map and with every pixel traced: radiances within the promise of both, and the truth.
    #[test]
    fn what_the_seam_cuts_is_as_every_pixel_traced() {
        let tilted =
            "kind = \"flat\"\nindex = 1.48\nridge_distance_mm = 78.472\nthickness_mm = 8.545\ntilt_deg = [1, 0.5, 2]";
        let bent = "kind = \"polynomial\"\nindex = 1.48\nposition_mm = [3.0, 0.0, 0.0]\n\
                    front = { centre_mm = [0, 0], scale_mm = [1, 1], domain_mm = [[-1, 20], [-9, 9]],\
                    terms = [[0, 0, 79], [1, 0, 0.155779], [0, 2, 0.004]] }\n\
                    back = { centre_mm = [0, 0], scale_mm = [1, 1], domain_mm = [[-1, 20], [-9, 9]],\
                    terms = [[0, 0, 87]] }";
        let board = "columns = 81\nrows = 81\nsquare_mm = 5.0\nposition_mm = [1.0, 2.0, 1000.0]\ntilt_deg = [3, 8, 1]";
        let solid = &bent
            .replace("[[0, 0, 87]]", "[[0, 0, 87], [1, 0, 0.03], [0, 2, 0.002]]")
            .replace("index", "solid = true\nindex");
        for (prism, seams) in [(tilted, 1), (bent, 1), (solid, 3)] {
            let plain = scene(800, 450, prism, board);
            let [by_map, traced] = [Accuracy::standard(), Accuracy::exact()].map(|accuracy| built(&plain, accuracy));
            let plan = Plan::new(&by_map);
            assert_eq!(plan.seams.len(), seams, "rays vouch for them\n{prism}");
            let film = |system: &System| picture(&Plan::new(system), Outputs { truth: true }, &());
            let (a, b) = (film(&by_map), film(&traced));
            assert_eq!(a.class, b.class, "{prism}");
            let (mut cut, mut lined) = (0, 0);
            let pixels = |seam: &SeamMap| {
                let Region { columns, rows } = seam.region.clone();
                rows.flat_map(move |j| columns.clone().map(move |i| (j, i)))
            };
            for (seam, (j, i)) in plan.seams.iter().flat_map(|seam| pixels(seam).map(move |pixel| (seam, pixel))) {
                let (mapped, exact) = (a.radiance.get(i, j), b.radiance.get(i, j));
                // The promises of both levels over a pixel's diagonal, for a contrast of 0.8, and roundings to f32.
                assert!(
                    (mapped - exact).abs() < 2.0 * 1e-5 * 1.42 * 0.8 + 1.2e-7,
                    "{i} {j}: {mapped} {exact}\n{prism}"
                );
                let [x, y] = [0, 1].map(|axis| {
                    let [mapped, exact] = [&a, &b].map(|film| film.board_mm.as_ref().expect("wanted").get(i, j)[axis]);
                    (mapped - exact).abs()
                });
                assert!(x.max(y) < 1e-4, "{i} {j}: {x} {y}");
                cut += usize::from((i as f64 + 0.5 - seam.column(j as f64 + 0.5)).abs() < 0.5);
                lined += usize::from(![0.05, 0.85].iter().any(|plain| (exact - plain).abs() < 1e-3));
            }
            assert!(cut >= 400 && lined > 100, "{cut} {lined}");
        }
    }
}
