//! The search: from a low degree to the wanted one, from two starts.

use super::merit::LawMerit;
use super::start::Start;
use super::unknowns::UnknownsLayout;
use crate::num::geodesic::{Patience, descend};
use nalgebra::DVector;

/// The degrees at which the flat prism is let go. There are side valleys, and none is the worse start always.
const FIRST_DEGREES: [usize; 2] = [3, 5];
/// A step of the search must gain this share, or the next degree gains more.
const PATIENCE: Patience = Patience { steps: 200, gain: 1e-4 };
/// Where two more degrees gain less than this factor, more will not help: exact prisms gain 80 to 100.
const FLOOR_GAIN: f64 = 4.0;
/// Below this many px the rounding of the rays is the floor, and not that of the objective.
const ROUNDING_PX: f64 = 1e-10;

/// The best surfaces of the wanted degree.
#[derive(Debug, Clone)]
pub(super) struct FoundPrism {
    pub(super) merit: LawMerit,
    pub(super) x: DVector<f64>,
    /// Square root of the merit, in px.
    pub(super) norm_px: f64,
    /// Whether two more degrees would gain little.
    pub(super) floor_reached: bool,
}

/// The best that is found; `None` where no start can be traced.
pub(super) fn search(start: &Start) -> Option<FoundPrism> {
    let degree = start.settings.degree;
    let met = FIRST_DEGREES[1];

    // Let the flat prism go at two degrees, and keep the better one where both have come to the same.
    let from = |first: usize| climb(start, flat(start, first.min(degree))?, met.min(degree));
    let found = if degree < met {
        from(FIRST_DEGREES[0])?
    } else {
        let (low, high) = rayon::join(|| from(FIRST_DEGREES[0]), || from(met));
        match (low, high) {
            (Some(low), Some(high)) => {
                if high.norm_px < low.norm_px {
                    // What two degrees gained is known of the other alone.
                    FoundPrism { floor_reached: low.floor_reached, ..high }
                } else {
                    low
                }
            }
            (low, high) => low.or(high)?,
        }
    };
    let found = climb(start, found, degree)?;
    Some(match from_law_alone(start) {
        Some(other) if other.norm_px < found.norm_px => other,
        _ => found,
    })
}

/// Where spots count, the surfaces of the law alone let go: what is found is then no worse by the merit than they are.
fn from_law_alone(start: &Start) -> Option<FoundPrism> {
    if start.settings.goal.spot_weight == 0.0 {
        return None;
    }
    let mut plain = *start;
    plain.settings.goal.spot_weight = 0.0;
    let found = search(&plain)?;
    let merit = start.merit(start.settings.degree);

    // The law's numbers have other ranges; the focus comes last, and starts in the middle of its own.
    let plain = &found.merit.layout;
    let mut x = found.x.as_slice()[..plain.law_start()].to_vec();
    let numbers = plain.free.iter().zip(&merit.layout.free).zip(found.x.as_slice()[plain.law_start()..].iter());
    x.extend(numbers.map(|(((_, before), (_, now)), s)| now.unknown(before.at(*s))));
    x.resize(merit.layout.len(), 0.0);
    Some(FoundPrism { floor_reached: found.floor_reached, ..descended(merit, DVector::from_vec(x))? })
}

/// The flat prism, let go over surfaces of a degree.
fn flat(start: &Start, degree: usize) -> Option<FoundPrism> {
    let merit = start.merit(degree);
    let x = start.unknowns(&merit.layout);
    descended(merit, x)
}

fn descended(merit: LawMerit, x: DVector<f64>) -> Option<FoundPrism> {
    let valley = descend(&merit, x, PATIENCE)?;
    Some(FoundPrism { merit, x: valley.x, norm_px: valley.norm, floor_reached: false })
}

/// From `found` up to `degree`, two degrees at a time.
fn climb(start: &Start, mut found: FoundPrism, degree: usize) -> Option<FoundPrism> {
    while found.merit.layout.bases[0].degree() < degree {
        let lower = &found.merit.layout;
        let gained_from = lower.bases[0].degree();
        let merit = start.merit((gained_from + 2).min(degree));
        let x = raised(&merit.layout, lower, &found.x);
        let next = descended(merit, x)?;
        let stuck = next.norm_px > ROUNDING_PX && next.norm_px * FLOOR_GAIN > found.norm_px;
        found = FoundPrism { floor_reached: stuck, ..next };
    }
    Some(found)
}

/// The unknowns of `lower` as those of a higher degree.
fn raised(layout: &UnknownsLayout, lower: &UnknownsLayout, x: &DVector<f64>) -> DVector<f64> {
    let candidate = lower.candidate(x);
    let [front, back] = candidate.sheets();
    let mut all = layout.bases[0].raised(front.basis, front.c);
    all.extend(layout.bases[1].raised(back.basis, back.c));
    all.extend_from_slice(candidate.others());
    DVector::from_vec(all)
}
