//! Light that crosses the plane of the ridge in the glass, and so looks through the other half's.

use super::instrument::System;
use crate::prism::side::Side;
use glam::DVec2;

/// What of a picture looks through the glass of the other half.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Crossing {
    /// Columns of the picture that hold such a pixel, in its first, middle or last row.
    pub columns: usize,
    /// Whether both halves have one back, so that it makes no difference.
    pub harmless: bool,
    /// Whether that light is traced through the back that it meets there, as in one piece of glass.
    pub solid: bool,
}

impl Crossing {
    /// Of the picture of an instrument, by the centres of its pixels; `None` without a prism.
    pub fn of(system: &System) -> Option<Self> {
        let prism = system.prism()?;
        let [width, height] = system.camera().size_px();
        let prism_from_world = prism.prism_from_world();
        let crosses = |column: usize, row: usize| {
            let (path, end) = system.path(DVec2::new(column as f64 + 0.5, row as f64 + 0.5));
            let ([_, leaves, ..], Ok((_, side))) = (&path.points[..], end) else { return false };
            (prism_from_world.point(*leaves).x < 0.0) == (side == Side::Right)
        };
        let rows = [0, height / 2, height - 1];
        Some(Self {
            columns: (0..width).filter(|column| rows.iter().any(|row| crosses(*column, *row))).count(),
            harmless: prism.has_one_back(),
            solid: prism.is_solid(),
        })
    }

    /// A sentence for people; `None` where no column does.
    pub fn words(&self) -> Option<String> {
        let Self { columns, harmless, solid } = *self;
        let how = match (harmless, solid) {
            (true, _) => "which has the same back",
            (false, true) => "and are traced through its back, as in one piece of glass",
            (false, false) => {
                "and are traced as if their own back went on there; `solid = true` in `[prism]` traces one piece of glass"
            }
        };
        (columns > 0)
            .then(|| format!("{columns} columns of the picture look through the glass of the other half, {how}"))
    }
}
