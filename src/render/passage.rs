//! What tells the places of a pixel apart: borders run between places of different passages.

use super::centre_rays::trace_scalar;
use super::film::Class;
use super::plan::{Creases, Plan};
use super::work::Work;
use glam::DVec2;

/// What becomes of a ray, and what it passes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Passage {
    /// Its class, with all that are dark as one.
    pub(super) class: Class,
    /// Of a prism with creases, the facets of front and back that it passes, where it is not dark.
    facets: [u32; 2],
}

impl Passage {
    /// The passage of the ray of `px`, whose class is known.
    pub(super) fn of(plan: &Plan, px: DVec2, class: Class) -> Self {
        let class = class.by_light();
        let followed = plan.creases == Creases::Few && class.side().is_some();
        Self { class, facets: if followed { plan.system().facets(px) } else { [0; 2] } }
    }

    /// The passage of the ray of `px`.
    pub(super) fn at(plan: &Plan, px: DVec2, work: &mut Work) -> Self {
        work.counts.rays += 1;
        Self::of(plan, px, trace_scalar(plan.system(), px).1)
    }
}
