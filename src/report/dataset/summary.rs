//! What a run made of a set, for a program and for a person.

use super::manifest::PoseLine;
use crate::analysis::dataset::{CameraResidual, SetCameras};
use crate::metrics::{Deviation, Unmeasurable};
use serde_json::{Value, json};

/// What the lines of a manifest come to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SetTally {
    /// Pictures.
    pub poses: usize,
    /// Fewest and most true corners in the left and the right half.
    pub corners: Option<[[usize; 2]; 2]>,
    /// Pictures of which a half has no corner.
    pub without_corners: usize,
    /// Clamped pixels of all.
    pub clamped_px: usize,
    /// Pictures that do not keep to the accuracy that was asked for.
    pub not_kept: usize,
}

impl SetTally {
    /// Adds a picture.
    pub fn add(&mut self, line: &PoseLine) {
        let counts = &line.counts;
        let known = self.corners.unwrap_or(counts.corners.map(|n| [n, n]));
        self.poses += 1;
        self.corners = Some([0, 1].map(|k| {
            let ([low, high], n) = (known[k], counts.corners[k]);
            [low.min(n), high.max(n)]
        }));
        self.without_corners += usize::from(counts.corners.contains(&0));
        self.clamped_px += counts.clamped_px;
        self.not_kept += usize::from(!counts.kept);
    }
}

/// What came of a run.
#[derive(Debug)]
pub struct SetSummary<'a> {
    /// Name of the scene.
    pub scene: &'a str,
    /// The folder, as it was named.
    pub out: String,
    /// Of the random numbers.
    pub seed: u64,
    /// Pictures that this run took.
    pub made: usize,
    /// All pictures of the folder.
    pub tally: SetTally,
    /// The cameras, where there are any.
    pub cameras: Option<&'a SetCameras>,
    /// Seconds that the pictures took.
    pub seconds: f64,
}

impl SetSummary<'_> {
    /// As JSON.
    pub fn json(&self) -> Value {
        let half =
            |k: usize| self.tally.corners.map(|corners| json!({ "least": corners[k][0], "most": corners[k][1] }));
        json!({
            "schema": "biprism-dataset-run/1",
            "scene": self.scene,
            "out": self.out,
            "seed": self.seed.to_string(),
            "poses": self.tally.poses,
            "made": self.made,
            "corners": { "left": half(0), "right": half(1) },
            "without_corners": self.tally.without_corners,
            "clamped_px": self.tally.clamped_px,
            "not_kept": self.tally.not_kept,
            "baseline_mm": self.cameras.map(SetCameras::baseline_mm),
            "deviation": self.cameras.map_or_else(Vec::new, |cameras| cameras.residuals.iter().map(residual).collect()),
            "timing_s": self.seconds,
        })
    }

    /// As words.
    pub fn words(&self) -> String {
        let SetTally { poses, corners, .. } = self.tally;
        let mut text =
            format!("{poses} poses in {}, {} of them made now in {:.1} s\n", self.out, self.made, self.seconds);
        if let Some([left, right]) = corners {
            text += &format!(
                "true corners: {} to {} in the left half, {} to {} in the right one\n",
                left[0], left[1], right[0], right[1]
            );
        }
        let Some(cameras) = self.cameras else { return text };
        text += &format!("baseline {:.4} mm\n", cameras.baseline_mm());
        for CameraResidual { distance_mm, raw, undone } in &cameras.residuals {
            let most = |[left, right]: &[Result<Deviation, Unmeasurable>; 2]| {
                let of = |side: &Result<Deviation, Unmeasurable>| side.as_ref().ok().map(|d| d.max);
                [of(left), of(right)].into_iter().flatten().fold(0.0, f64::max)
            };
            text += &format!("from their pinholes at {distance_mm} mm at most {:.2e} px", most(raw));
            if cameras.row_shifts.iter().flatten().count() == 2 {
                text += &format!(", with the shift of the rows undone {:.2e} px", most(undone));
            }
            text += "\n";
        }
        text
    }
}

fn residual(found: &CameraResidual) -> Value {
    let side = |found: &Result<Deviation, Unmeasurable>| {
        found.as_ref().ok().map(|d| json!({ "n": d.n, "rms_px": d.rms, "max_px": d.max }))
    };
    let both =
        |[left, right]: &[Result<Deviation, Unmeasurable>; 2]| json!({ "left": side(left), "right": side(right) });
    json!({ "distance_mm": found.distance_mm, "raw": both(&found.raw), "rows_shifted_back": both(&found.undone) })
}
