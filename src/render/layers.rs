//! Pictures of a board with objects before it: each alone by its own plan, as if nothing else were there, and of every pixel the
//! one that is nearest all over it. Pixels in which that changes are traced in parts, each of which is cut along the borders of the
//! objects and along the lines where two of them pass through each other: straight lines under the tangent of the map.

use super::band::{Band, Truth};
use super::film::Class;
use super::pixel::{INSET_PX, adaptive, square};
use super::plan::Plan;
use super::sights::{Sight, alone, sights};
use super::work::Work;
use crate::system::System;
use crate::texture::Convex;
use glam::DVec2;
use std::iter::once;

/// A loop that renders a band of one plan alone.
type BandPainter = fn(&Plan, &mut Band) -> Work;

/// Renders the band of `plan`, whose board and objects are each rendered by `paint`.
pub(super) fn render(plan: &Plan, band: &mut Band, paint: BandPainter) -> Work {
    // Render each alone, with a pixel around the band.
    let mut work = Work::default();
    let area = Area::around(plan, band);
    let layers: Vec<LayerPicture> =
        once(plan).chain(&plan.objects).map(|one| LayerPicture::new(one, &area, paint, &mut work)).collect();
    let nearest: Vec<Option<usize>> = (0..area.width * area.height).map(|at| nearest(&layers, &area, at)).collect();

    // Take each pixel from the nearest, or trace it in parts.
    for j in 0..band.rows() {
        for i in 0..band.width {
            let at = area.index(band.first_column + i, band.first_row + j);
            let own = nearest[at].filter(|own| area.around_of(at).all(|k| nearest[k] == Some(*own)));
            let px = DVec2::new((band.first_column + i) as f64 + 0.5, (band.first_row + j) as f64 + 0.5);
            let own = own.or_else(|| alone(plan, px, &mut work));
            let to = j * band.width + i;
            band.radiance[to] = match own {
                Some(own) => layers[own].radiance[at],
                None if plan.truth_alone => 0.0,
                None => divided(plan, px, &mut work) as f32,
            };
            if let Some(truth) = &mut band.truth {
                let found = match own {
                    Some(own) => (own, layers[own].class[at], layers[own].board_mm[at]),
                    None => seen(plan, px, &mut work),
                };
                store(truth, to, found);
            }
        }
    }
    work
}

fn store(truth: &mut Truth, at: usize, (object, class, board_mm): (usize, Class, [f32; 2])) {
    truth.class[at] = class;
    truth.board_mm[at] = board_mm;
    if let Some(objects) = &mut truth.object {
        objects[at] = object as u32;
    }
}

/// What the centre of a pixel sees: the number of the object, the class, and the place on it.
fn seen(plan: &Plan, px: DVec2, work: &mut Work) -> (usize, Class, [f32; 2]) {
    work.counts.rays += 1;
    let found = plan.system.exit_ray(px).and_then(|(ray, side)| Ok((plan.system.nearest(&ray)?, side)));
    match found {
        Ok(((object, mm, _), side)) => (object, side.into(), [mm.x as f32, mm.y as f32]),
        Err(fate) => (0, fate.into(), [0.0; 2]),
    }
}

/// A band with a pixel around it, where the picture has one.
struct Area {
    first: [usize; 2],
    width: usize,
    height: usize,
    picture: [usize; 2],
}

impl Area {
    fn around(plan: &Plan, band: &Band) -> Self {
        let size = plan.system.camera().size_px();
        let (first, count) = ([band.first_column, band.first_row], [band.width, band.rows()]);
        let low = first.map(|n| n.saturating_sub(1));
        let high = [0, 1].map(|axis| size[axis].min(first[axis] + count[axis] + 1));
        Self { first: low, width: high[0] - low[0], height: high[1] - low[1], picture: size }
    }

    fn index(&self, x: usize, y: usize) -> usize {
        (y - self.first[1]) * self.width + x - self.first[0]
    }

    /// Whether the pixel lies at the border of the picture.
    fn is_at_border(&self, at: usize) -> bool {
        let place = [at % self.width + self.first[0], at / self.width + self.first[1]];
        (0..2).any(|axis| place[axis] == 0 || place[axis] + 1 == self.picture[axis])
    }

    /// The pixel and those around it that lie in the area.
    fn around_of(&self, at: usize) -> impl Iterator<Item = usize> + Clone + use<> {
        let (width, i, j) = (self.width, at % self.width, at / self.width);
        let rows = j.saturating_sub(1)..(j + 2).min(self.height);
        let columns = i.saturating_sub(1)..(i + 2).min(self.width);
        rows.flat_map(move |j| columns.clone().map(move |i| j * width + i))
    }
}

/// The picture of one thing alone, with its truth.
struct LayerPicture<'a> {
    system: &'a System,
    half_mm: DVec2,
    radiance: Vec<f32>,
    class: Vec<Class>,
    board_mm: Vec<[f32; 2]>,
}

/// How much of a pixel a thing covers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Cover {
    None,
    Part,
    All,
}

impl<'a> LayerPicture<'a> {
    fn new(plan: &Plan<'a>, area: &Area, paint: BandPainter, work: &mut Work) -> Self {
        let n = area.width * area.height;
        let mut layer = Self {
            system: plan.system,
            half_mm: plan.system.half_plate_mm(),
            radiance: vec![0.0; n],
            class: vec![Class::Left; n],
            board_mm: vec![[0.0; 2]; n],
        };
        let truth = Truth { class: &mut layer.class, board_mm: &mut layer.board_mm, object: None };
        let [first_column, first_row] = area.first;
        let mut band =
            Band { width: area.width, first_column, first_row, radiance: &mut layer.radiance, truth: Some(truth) };
        *work += paint(plan, &mut band);
        layer
    }

    fn mm(&self, at: usize) -> DVec2 {
        DVec2::new(f64::from(self.board_mm[at][0]), f64::from(self.board_mm[at][1]))
    }

    /// How far what a pixel's centre sees of its plane is from the camera, in mm, where it sees it.
    fn distance_mm(&self, at: usize) -> Option<f64> {
        self.class[at].side()?;
        Some((self.system.board().world(self.mm(at)) - self.system.camera().position_mm()).length())
    }

    /// How much of a pixel its plate covers, by the places that its centre and those around it see: what a pixel sees through a side
    /// lies within a step beyond the places of that side.
    fn cover(&self, area: &Area, at: usize) -> Cover {
        // Find what the centres see through each side, and the longest step between any two.
        let around = area.around_of(at);
        let sides = [Class::Left, Class::Right].map(|side| {
            let own = around.clone().filter(|k| self.class[*k] == side);
            let start = (DVec2::INFINITY, DVec2::NEG_INFINITY, 0);
            own.fold(start, |(low, high, n), k| (low.min(self.mm(k)), high.max(self.mm(k)), n + 1))
        });
        let seen = sides.iter().filter(|(.., n)| *n > 0);
        let longest = seen.clone().map(|(low, high, _)| (*high - *low).max_element()).fold(0.0, f64::max);

        // Compare them with the plate.
        let mut cover = None;
        for (low, high, n) in seen {
            // Six of nine places are steps apart along both axes; of fewer the steps along one may not be known.
            let step = if *n < 6 { DVec2::splat(4.0 * longest) } else { *high - *low };
            let step = if step.max_element() > 0.0 { step } else { DVec2::INFINITY };
            let (low, high) = (*low - step, *high + step);
            let of_side = if low.cmpge(-self.half_mm).all() && high.cmple(self.half_mm).all() {
                Cover::All
            } else if low.cmpgt(self.half_mm).any() || high.cmplt(-self.half_mm).any() {
                Cover::None
            } else {
                Cover::Part
            };
            cover = Some(if cover.is_none_or(|other| other == of_side) { of_side } else { Cover::Part });
        }
        let past = around.clone().any(|k| self.class[k] == Class::PastBoard);
        match cover {
            // Where its plane goes out of sight.
            Some(_) if past => Cover::Part,
            Some(cover) => cover,
            None => Cover::None,
        }
    }
}

/// The thing that is nearest all over a pixel, 0 for the board and what is beside it; `None` where that is not known.
fn nearest(layers: &[LayerPicture], area: &Area, at: usize) -> Option<usize> {
    // Find the nearest of those that cover all of it.
    let covers: Vec<Cover> = layers.iter().map(|layer| layer.cover(area, at)).collect();
    let all = (0..layers.len()).filter(|k| covers[*k] == Cover::All);
    let distances = all.filter_map(|k| Some((k, layers[k].distance_mm(at)?)));
    let own = distances.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(k, _)| k);

    // Leave it where another may be nearer somewhere: one that covers a part of it, and at the border of the picture, where no centre lies
    // beyond and distances go on as from those within, also one that covers all.
    let at_border = area.is_at_border(at);
    let off_mm = |other: usize, k: usize| Some(layers[other].distance_mm(k)? - layers[own?].distance_mm(k)?);
    let stays_behind = |other: usize| {
        off_mm(other, at).is_some_and(|here| {
            let behind = |off_mm: f64| off_mm > 0.0 && (!at_border || 2.0 * here - off_mm > 0.0);
            area.around_of(at).all(|k| off_mm(other, k).is_some_and(behind))
        })
    };
    let may_be_nearer =
        |k: &usize| covers[*k] == Cover::Part || at_border && covers[*k] == Cover::All && Some(*k) != own;
    (0..layers.len()).filter(may_be_nearer).all(stays_behind).then(|| own.unwrap_or(0))
}

/// The light of a pixel from ever smaller parts.
fn divided(plan: &Plan, px: DVec2, work: &mut Work) -> f64 {
    work.counts.edge_pixels += 1;
    work.counts.divided_pixels += 1;
    // The ridge and the borders of fates are not followed in it.
    if plan.system.prism().is_some() {
        let corners = square(0.5 * plan.active - INSET_PX);
        let sides = corners.map(|corner| plan.system.exit_ray(px + corner).map(|(_, side)| side));
        work.counts.rays += 4;
        work.counts.unpromised_pixels += u64::from(sides.iter().any(|side| *side != sides[0]));
    }
    let mut by_parts = |depth: u32, work: &mut Work| {
        let n = 2u32 << depth;
        let side = plan.active / f64::from(n);
        let place = |k: u32| (f64::from(2 * k + 1) - f64::from(n)) * (0.5 * side);
        let parts = (0..n * n).map(|k| DVec2::new(place(k % n), place(k / n)));
        let sum: f64 = parts.map(|at| part(plan, px + at, 0.5 * side, work)).sum();
        sum / f64::from(n * n)
    };
    adaptive(plan, 0.0, &mut by_parts, work)
}

/// The mean light of a square part of a pixel about `px`, of side 2 `half`, by the tangent of the map there.
fn part(plan: &Plan, px: DVec2, half: f64, work: &mut Work) -> f64 {
    // Trace the ray, and find how it sees the board and the objects.
    work.counts.rays += 1;
    let Some((_, sights)) = sights(plan, px) else { return 0.0 };
    let sights: Vec<Sight> = sights.into_iter().flatten().collect();

    // Cut the part along the borders of plates, and where two of them are equally far.
    let mut cells = vec![Convex::new(&square(half))];
    for sight in &sights {
        (0..4).for_each(|side| split(&mut cells, |px| sight.within(px, side)));
    }
    for (k, a) in sights.iter().enumerate() {
        sights[..k].iter().for_each(|b| split(&mut cells, |px| a.distance(px) - b.distance(px)));
    }

    // Sum up what is nearest in each cell.
    let background = plan.face().background() * plan.throughput(px);
    let light = |cell: &Convex| {
        let vertices = cell.vertices();
        let middle = vertices.iter().copied().sum::<DVec2>() / vertices.len() as f64;
        let covering = sights.iter().filter(|sight| sight.covers(middle));
        let nearest = covering.min_by(|a, b| a.distance(middle).total_cmp(&b.distance(middle)));
        let mean = nearest.map_or(background, |sight| mean_over(sight, vertices, middle) * sight.plan.throughput(px));
        cell.area() * mean
    };
    cells.iter().map(light).sum::<f64>() / (4.0 * half * half)
}

/// The mean radiance of a thing over a convex polygon about a ray, whose middle is given.
fn mean_over(sight: &Sight, vertices: &[DVec2], middle: DVec2) -> f64 {
    let face = sight.plan.face();
    let scale = face.squares_per_mm();
    // By triangles, of which none has too many corners for a texture.
    let (mut sum, mut areas) = (0.0, 0.0);
    for k in 1..vertices.len() - 1 {
        let triangle = [vertices[0], vertices[k], vertices[k + 1]];
        let area = (triangle[1] - triangle[0]).perp_dot(triangle[2] - triangle[0]);
        let mean = face.mean_over(&triangle.map(|px| sight.mm(px) * scale));
        sum += area * mean.unwrap_or_else(|| face.at(sight.mm((triangle[0] + triangle[1] + triangle[2]) / 3.0)));
        areas += area;
    }
    if areas > 0.0 { sum / areas } else { face.at(sight.mm(middle)) }
}

/// Cuts the cells through which the line passes on which `f`, a linear function, is 0.
fn split(cells: &mut Vec<Convex>, f: impl Fn(DVec2) -> f64) {
    for k in 0..cells.len() {
        let cell = cells[k];
        let (below, above) = cell.vertices().iter().fold((false, false), |(below, above), px| {
            let value = f(*px);
            (below || value < 0.0, above || value > 0.0)
        });
        if below && above {
            cells[k] = cell.cut(&f);
            cells.push(cell.cut(|px| -f(px)));
        }
    }
    cells.retain(|cell| cell.area() > 0.0);
}
