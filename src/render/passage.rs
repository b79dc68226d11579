//! What tells the places of a pixel apart: borders run between places of different passages.

use super::centre_rays::trace_scalar;
use super::film::Class;
use super::plan::{PartBorders, Plan};
use super::work::Work;
use crate::prism::payload::PartsPassed;
use glam::DVec2;

/// What becomes of a ray, and what it passes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Passage {
    /// Its class, with all that are dark as one.
    pub(super) class: Class,
    /// Where creases are followed, the facets of front and back that it passes, unless it is dark.
    facets: [u32; 2],
    /// Where kinks are followed, the pieces of these.
    pieces: [u32; 2],
}

impl Passage {
    /// The passage of the ray of `px`, whose class is known.
    pub(super) fn of(plan: &Plan, px: DVec2, class: Class) -> Self {
        let parts = if class.side().is_some() && Self::are_parted(plan) {
            plan.system().parts(px)
        } else {
            PartsPassed::default()
        };
        Self::by(plan, class, parts)
    }

    /// Whether places of one class may be of several passages.
    fn are_parted(plan: &Plan) -> bool {
        [plan.creases, plan.kinks].contains(&PartBorders::Few)
    }

    /// The passage of a ray of this class through these parts.
    fn by(plan: &Plan, class: Class, parts: PartsPassed) -> Self {
        let class = class.by_light();
        let [creases, kinks] = [plan.creases, plan.kinks].map(|borders| borders == PartBorders::Few);
        if class.side().is_none() {
            return Self { class, facets: [0; 2], pieces: [0; 2] };
        }
        let of = |followed: bool, names: [u32; 2]| if followed { names } else { [0; 2] };
        Self { class, facets: of(creases, parts.facets), pieces: of(kinks, parts.pieces) }
    }

    /// The passage of the ray of `px`.
    pub(super) fn at(plan: &Plan, px: DVec2, work: &mut Work) -> Self {
        work.counts.rays += 1;
        if !Self::are_parted(plan) {
            return Self::by(plan, trace_scalar(plan.system(), px).1, PartsPassed::default());
        }
        let (sight, parts) = plan.system().trace_with_parts(px);
        Self::by(plan, sight.map_or_else(Class::from, |sight| sight.side.into()), parts)
    }

    /// Whether nothing jumps from one to the other, though it may have a kink.
    pub(super) fn joins(&self, other: &Self) -> bool {
        (self.class, self.facets) == (other.class, other.facets)
    }
}
