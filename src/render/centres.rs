//! Centres of the pixels of a tile and of those around it: what they see, and by which parts of the glass.

use super::band::Band;
use super::centre_rays::Run;
use super::film::Class;
use super::pixel_mean::Taylor2;
use super::plan::{PartBorders, Plan};
use super::region::Region;
use crate::num::simd::LANES;
use crate::prism::triangles::TrianglePair;
use glam::DVec2;

/// Centres of the pixels of a tile and of those around it, row by row.
pub(super) struct Centres {
    pub(super) stride: usize,
    pub(super) x_mm: Vec<f64>,
    pub(super) y_mm: Vec<f64>,
    pub(super) class: Vec<Class>,
    /// The triangles that each passes, where these tell what is seen; else of a prism with creases the facets.
    pub(super) parts: Option<Vec<[u32; 2]>>,
}

/// Traces the centres of `rect` and of one pixel around it, or the places `off` them, in px.
pub(super) fn trace(plan: &Plan, rect: &Region, off: DVec2) -> Centres {
    let (stride, rows) = (rect.columns.len() + 2, rect.rows.len() + 2);
    let size = stride * rows + LANES + 1;
    let mut centres = Centres {
        stride,
        x_mm: vec![0.0; size],
        y_mm: vec![0.0; size],
        class: vec![Class::Missed; stride * rows],
        parts: None,
    };
    if plan.by_triangles || plan.creases != PartBorders::None {
        trace_with_parts(plan, rect, off, &mut centres);
        return centres;
    }
    for j in 0..rows {
        let start = first_place(rect, off) + DVec2::new(0.0, j as f64);
        let span = j * stride..(j + 1) * stride;
        let (x_mm, y_mm) = (&mut centres.x_mm[span.clone()], &mut centres.y_mm[span.clone()]);
        plan.centre_tracer.trace(start, Run { x_mm, y_mm, class: &mut centres.class[span] });
    }
    centres
}

/// The first of the places that are traced of a tile.
fn first_place(rect: &Region, off: DVec2) -> DVec2 {
    off + DVec2::new(rect.columns.start as f64 - 0.5, rect.rows.start as f64 - 0.5)
}

/// Traces all places of a tile, with the parts of the surfaces that each ray passes.
fn trace_with_parts(plan: &Plan, rect: &Region, off: DVec2, centres: &mut Centres) {
    let (stride, count) = (centres.stride, centres.class.len());
    let place = |k: usize| first_place(rect, off) + DVec2::new((k % stride) as f64, (k / stride) as f64);
    let one = |centres: &mut Centres, k: usize| {
        let (sight, parts) = plan.system.trace_with_parts(place(k));
        match sight {
            Ok(sight) => {
                (centres.x_mm[k], centres.y_mm[k]) = (sight.board_mm.x, sight.board_mm.y);
                centres.class[k] = sight.side.into();
            }
            Err(fate) => centres.class[k] = fate.into(),
        }
        if plan.by_triangles { parts.triangles } else { parts.facets }
    };

    // Take packets within rows where triangles tell what is seen.
    let mut parts = Vec::with_capacity(count);
    while parts.len() < count {
        let k = parts.len();
        let packet = plan.by_triangles && k % stride + LANES <= stride;
        let beside = if k.is_multiple_of(stride) { k.checked_sub(stride) } else { Some(k - 1) }.map(|k| parts[k]);
        match packet.then(|| plan.system.trace_through_triangles(place(k), beside)).flatten() {
            None => parts.push(one(centres, k)),
            Some(([x_mm, y_mm], side, [front, back])) => {
                centres.x_mm[k..k + LANES].copy_from_slice(&x_mm.0);
                centres.y_mm[k..k + LANES].copy_from_slice(&y_mm.0);
                centres.class[k..k + LANES].fill(side.into());
                parts.extend(front.into_iter().zip(back).map(|(front, back)| [front, back]));
            }
        }
    }
    centres.parts = Some(parts);
}

impl Centres {
    /// Stores what `count` centres from `at` on see as the ground truth of the pixels of `band` from `start` on.
    pub(super) fn store_truth(&self, at: usize, band: &mut Band, start: usize, count: usize) {
        let Some(truth) = &mut band.truth else { return };
        for i in 0..count {
            truth.class[start + i] = self.class[at + i];
            truth.board_mm[start + i] = [self.x_mm[at + i] as f32, self.y_mm[at + i] as f32];
        }
    }

    /// Stores what the centres of `rect` see as the ground truth of its pixels.
    pub(super) fn store_all_truth(&self, rect: &Region, band: &mut Band) {
        for (j, y) in rect.rows.clone().enumerate() {
            let start = band.at(rect.columns.start, y);
            self.store_truth((j + 1) * self.stride + 1, band, start, rect.columns.len());
        }
    }

    /// The triangles that the centre of index `at` sees, where they tell what is seen.
    pub(super) fn triangles(&self, at: usize) -> Option<TrianglePair> {
        let (side, triangles) = (self.class[at].side()?, self.parts.as_ref()?[at]);
        Some(TrianglePair { side, triangles })
    }

    /// How many see the board.
    pub(super) fn lit(&self) -> usize {
        self.class.iter().filter(|class| class.side().is_some()).count()
    }

    /// Whether the eight neighbours of the centre of index `at` are of its class.
    pub(super) fn is_amid_its_class(&self, at: usize) -> bool {
        let rows = [at - self.stride, at, at + self.stride];
        rows.iter().all(|&k| self.class[k - 1..=k + 1].iter().all(|c| *c == self.class[at]))
    }

    /// Whether it or one of its neighbours sees nothing of the board.
    pub(super) fn is_beside_a_fate(&self, at: usize) -> bool {
        let rows = [at - self.stride, at, at + self.stride];
        rows.iter().any(|&k| self.class[k - 1..=k + 1].iter().any(|class| class.side().is_none()))
    }

    /// Whether one of its neighbours passes other parts of the same side.
    pub(super) fn is_beside_other_parts(&self, at: usize) -> bool {
        let Some(parts) = &self.parts else { return false };
        let rows = [at - self.stride, at, at + self.stride];
        let differs = |other: usize| parts[other] != parts[at] && self.class[other] == self.class[at];
        rows.iter().any(|&k| (k - 1..=k + 1).any(differs))
    }

    /// Of the corners of pixels, by their top left ones: whether those of the pixel of index `at` pass several parts of a side.
    pub(super) fn parts_differ(&self, at: usize) -> bool {
        let Some(parts) = &self.parts else { return false };
        [at + 1, at + self.stride, at + self.stride + 1]
            .iter()
            .any(|&k| parts[k] != parts[at] && self.class[k] == self.class[at])
    }

    /// Of the corners of pixels, by their top left ones: whether one of the pixel of index `at` is not of class `own`.
    pub(super) fn differ_from(&self, own: Class, at: usize) -> bool {
        [at, at + 1, at + self.stride, at + self.stride + 1].iter().any(|&k| self.class[k] != own)
    }

    /// Whether it and its neighbours see through one side.
    pub(super) fn is_amid_its_side(&self, at: usize) -> bool {
        self.class[at].side().is_some() && self.is_amid_its_class(at)
    }

    /// The map about the centre of index `at`, by differences of its neighbours; written so that mirror images have the
    /// same bits.
    #[inline(always)]
    pub(super) fn taylor2(&self, at: usize, squares_per_mm: f64) -> Taylor2 {
        let see = |k: usize| DVec2::new(self.x_mm[k], self.y_mm[k]) * squares_per_mm;
        let [above, below] = [at - self.stride, at + self.stride];
        let seen = see(at);
        Taylor2 {
            seen,
            dx: 0.5 * (see(at + 1) - see(at - 1)),
            dy: 0.5 * (see(below) - see(above)),
            dxx: (see(at + 1) + see(at - 1)) - 2.0 * seen,
            dxy: 0.25 * ((see(below + 1) - see(below - 1)) - (see(above + 1) - see(above - 1))),
            dyy: (see(below) + see(above)) - 2.0 * seen,
        }
    }
}
