//! Counters of a part of a picture: the work it took, and the bend left inside its pixels.

use super::film::Counts;

/// The account of a part of a picture.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Work {
    pub(super) counts: Counts,
    pub(super) bend_px: f64,
}

impl std::ops::AddAssign for Work {
    fn add_assign(&mut self, other: Self) {
        self.counts += other.counts;
        self.bend_px = self.bend_px.max(other.bend_px);
    }
}
