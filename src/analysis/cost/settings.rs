//! Settings of the study: how much it does.

use crate::accuracy::Level;

/// How much the study does.
#[derive(Debug, Clone, PartialEq)]
pub struct CostSettings {
    /// Repetitions of each setting.
    pub repetitions: usize,
    /// A setting is not repeated once it has taken this long altogether, in s.
    pub patience_s: f64,
    /// Levels of accuracy that are timed.
    pub levels: Vec<Level>,
    /// Bends that pixels are divided for, in px.
    pub bends_px: Vec<f64>,
    /// Side of the grids of samples a pixel that stand for a renderer without knowledge of its scene.
    pub supersampling: Vec<usize>,
    /// Steps of the design's integration, in um on the sensor.
    pub steps_um: Vec<f64>,
    /// Degrees of the polynomials that are fitted to a design.
    pub degrees: Vec<usize>,
    /// Triangles of front and back together.
    pub triangles: Vec<usize>,
    /// Points of the pupil of a lens.
    pub pupil_points: Vec<usize>,
    /// Those of the picture that a lens is held against.
    pub pupil_reference: usize,
    /// Triangles of the prism that is rendered as a mesh, front and back together; none where it is not.
    pub mesh_triangles: Option<usize>,
}

impl Default for CostSettings {
    /// The ranges of the design paper's Fig. 4(b) and beyond.
    fn default() -> Self {
        Self {
            repetitions: 7,
            patience_s: 6.0,
            levels: Level::ALL.to_vec(),
            bends_px: vec![1e-2, 1e-4, 1e-6, 1e-8],
            supersampling: vec![1, 2, 4, 8],
            steps_um: vec![91.0, 55.0, 22.0, 11.0, 5.5, 2.75, 1.0],
            degrees: vec![3, 4, 5, 6, 7, 9],
            triangles: vec![1_000, 10_000, 100_000, 1_000_000],
            pupil_points: vec![8, 32, 128, 512],
            pupil_reference: 2048,
            mesh_triangles: Some(1_000),
        }
    }
}

impl CostSettings {
    /// A first look: the cheap end of each range. Of the reference only the picture is rendered that others are held
    /// against, and no picture of the prism as a mesh, whose reference is the dearest of all.
    pub fn quick() -> Self {
        Self {
            patience_s: 0.5,
            levels: Level::ALL.into_iter().filter(|level| *level != Level::Reference).collect(),
            bends_px: vec![1e-2, 1e-4, 1e-6],
            supersampling: vec![1, 2],
            steps_um: vec![91.0, 22.0],
            degrees: vec![3, 5],
            triangles: vec![1_000],
            pupil_points: vec![8, 32],
            pupil_reference: 128,
            mesh_triangles: None,
            ..Self::default()
        }
    }
}
