//! What an objective cannot have, in words.

use super::search::FoundPrism;
use crate::error::Error;
use crate::scene::{DesignSettings, Objective, Rear};

/// A prism that misses its law by more than this, root mean square over half image and depths, does not meet it, in px: its
/// residual would be seen in a picture's corners.
const MOST_PX: f64 = 0.1;

/// The objective as a scene calls it.
fn named(objective: Objective) -> &'static str {
    match objective {
        Objective::March => "march",
        Objective::Epipolar => "epipolar",
        Objective::ToedIn => "toed-in",
        Objective::Pinhole => "pinhole",
        Objective::Depth => "depth",
    }
}

fn rear_named(rear: Rear) -> &'static str {
    match rear {
        Rear::Own => "own",
        Rear::Even => "even",
        Rear::Flat => "flat",
    }
}

/// The error of a flat prism, or of all surfaces near it, that rays of the half image do not pass.
pub(super) fn no_start(settings: &DesignSettings) -> Error {
    Error::new(
        "the prism's design",
        format!(
            "a ray of the half image does not pass the flat prism that `prism.design.objective` = \"{}\" starts from: it \
             misses the glass, which ends before the edge of the picture, or is totally reflected",
            named(settings.objective)
        ),
        "use a thicker prism, a longer focal length or a smaller sensor",
    )
}

/// Refuses what misses its law: by the surfaces that were asked for, or by its degree.
///
/// # Errors
/// An [`Error`] that names the residual.
pub(super) fn check(settings: &DesignSettings, found: &FoundPrism) -> Result<(), Error> {
    let (objective, rear) = (settings.objective, settings.goal.rear);
    // What a floor forbids is refused whatever is left.
    let help = match (objective, rear) {
        (Objective::Pinhole, Rear::Even | Rear::Flat) => {
            "write rear = \"own\", or objective = \"toed-in\", which one rear surface allows"
        }
        (Objective::Depth, Rear::Even | Rear::Flat) => {
            "write rear = \"own\", or objective = \"epipolar\" with rear = \"even\""
        }
        (Objective::Epipolar, Rear::Flat) => "write rear = \"even\", one surface for both halves as well",
        _ => return residual(settings, found),
    };
    Err(Error::new(
        "the prism's design",
        format!(
            "`prism.design.objective` = \"{}\" cannot be had with `prism.design.rear` = \"{}\": a floor of {:.3} px remains",
            named(objective),
            rear_named(rear),
            found.norm_px
        ),
        help,
    ))
}

/// Refuses polynomials through an exact prism that leave `left_px` of its law.
///
/// # Errors
/// An [`Error`] that names the residual.
pub(in crate::design) fn fitted(settings: &DesignSettings, left_px: f64) -> Result<(), Error> {
    if left_px <= MOST_PX {
        return Ok(());
    }
    Err(Error::new(
        "the prism's design",
        format!(
            "polynomials of degree {} leave {left_px:.3} px RMS of `prism.design.objective` = \"{}\", and may leave {MOST_PX}",
            settings.degree,
            named(settings.objective)
        ),
        "raise `prism.design.degree`, or write surface = \"revolved\" for the surfaces themselves",
    ))
}

/// Refuses what is left of a law that could be met.
fn residual(settings: &DesignSettings, found: &FoundPrism) -> Result<(), Error> {
    // Of a merit with spots a part is theirs, as the user weighs it.
    if found.norm_px <= MOST_PX || found.merit.spot.is_some() {
        return Ok(());
    }
    let degree = settings.degree;
    let help = if found.floor_reached {
        match (settings.objective, settings.goal.rear) {
            (Objective::Pinhole, _) => "write objective = \"toed-in\" or \"epipolar\", which have no such floor",
            (_, Rear::Even | Rear::Flat) => "write rear = \"own\", or use a longer focal length",
            _ => "use a thicker prism, a longer focal length or a smaller sensor",
        }
    } else {
        "raise `prism.design.degree`, or use a longer focal length or a smaller sensor"
    };
    let floor = if found.floor_reached { ", a floor that higher degrees do not lower" } else { "" };
    Err(Error::new(
        "the prism's design",
        format!(
            "`prism.design.objective` = \"{}\" is not met at `prism.design.degree` = {degree}: {:.3} px RMS remain{floor}, and \
             {MOST_PX} are allowed",
            named(settings.objective),
            found.norm_px
        ),
        help,
    ))
}
