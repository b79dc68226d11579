//! The board's corners as marks: where the reference sees them, and what another way sees there.

use super::shifts::{Shifts, shift_px};
use crate::accuracy::Accuracy;
use crate::analysis::half_image::HalfFrame;
use crate::analysis::truth;
use crate::render::Plan;
use crate::system::aim::Aimer;
use crate::system::{Side, System};
use crate::vision::half::Half;
use glam::{DMat2, DVec2};

/// A corner as the reference has it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Mark {
    /// In the picture, in px.
    pub(super) px: DVec2,
    /// On the board, in mm.
    pub(super) board_mm: DVec2,
    /// d board / d px there.
    pub(super) jacobian: DMat2,
    /// Seen through this side.
    pub(super) side: Side,
}

/// The corners of a picture.
#[derive(Debug)]
pub(super) struct ReferenceCorners {
    pub(super) marks: Vec<Mark>,
}

impl ReferenceCorners {
    /// All inner corners that `reference` sees, by the exact inverse trace.
    pub(super) fn of(reference: &System) -> Self {
        let aimer = Aimer::new(reference);
        let mut marks = Vec::new();
        for half in [Half::Left, Half::Right] {
            let frame = HalfFrame::new(reference, half);
            for (index, corner) in truth::corners(reference, &aimer, &frame).into_iter().flatten() {
                let px = frame.full(corner.position_px);
                let board_mm = reference.board().corner_at(f64::from(index[0]), f64::from(index[1]));
                marks.extend(reference.footprint(px).ok().map(|f| Mark {
                    px,
                    board_mm,
                    jacobian: f.jacobian,
                    side: f.sight.side,
                }));
            }
        }
        Self { marks }
    }

    pub(super) fn count(&self) -> usize {
        self.marks.len()
    }

    /// How far from the corners lies what `accuracy` says that their positions see; `None` where it sees nothing.
    pub(super) fn shifts(&self, system: &System, accuracy: Accuracy) -> Option<Shifts> {
        let system = system.with_accuracy(accuracy);
        let plan = Plan::new(&system);
        let shift = |m: &Mark| plan.trace(m.px).ok().map(|seen| shift_px(m.jacobian, seen - m.board_mm));
        Shifts::of(&self.marks.iter().map(shift).collect::<Option<Vec<f64>>>()?)
    }
}
