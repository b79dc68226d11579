//! What a picture of the board shows: corners found in each half, and beside them the exact ones.

use super::board_indexing::{Found, anchor};
use super::half_image::{HalfFrame, NoPinhole, epipolar_shift, row_shift, virtual_camera};
use super::not_judged_cause::NotJudged;
use super::truth::{self, TrueCorners};
use crate::metrics::pinhole::Pinhole;
use crate::metrics::row_law::RowShift;
use crate::metrics::straightness::IndexedCorner;
use crate::metrics::{Deviation, Observation};
use crate::progress::Observer;
use crate::raster::Raster;
use crate::system::aim::Aimer;
use crate::system::{Board, Camera, InLight, System};
use crate::vision::half::{Half, HalfImage};
use crate::vision::{self, Detection, LatticeCorner};
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// How far a detected corner may lie from the true corner of its index, as a share of a square.
const SAME_CORNER: f64 = 0.25;

/// How the detected corners compare with the exact ones.
#[derive(Debug, Clone, PartialEq)]
pub struct Detected {
    /// True corners whose four squares lie wholly in the half; `None` where the truth is unknown.
    pub visible: Option<usize>,
    /// How many of these were found; all that were found, where the truth is unknown.
    pub found: usize,
    /// Detected corners of which some square is cut by the border of the half.
    pub partial: usize,
    /// Detected corners with no true corner of their index within a quarter of a square.
    pub wrong: Option<usize>,
    /// Measured minus true position of all right ones, in px.
    pub errors_px: Vec<DVec2>,
    /// Corners of the lattice that the detector found, whether or not their places on the board are known.
    pub lattice: usize,
    /// Candidates that were turned down, by reason.
    pub rejected: BTreeMap<String, usize>,
    /// Estimated blur of the picture along the two families of lines, in px.
    pub blur_px: Option<[f64; 2]>,
}

/// One half of a picture.
#[derive(Debug, Clone)]
pub struct HalfView {
    /// Its place in the picture.
    pub frame: HalfFrame,
    /// The camera that took it.
    pub taken_by: Camera,
    /// The camera that it is designed to be, in the half's own px, rectified.
    pub camera: Result<Pinhole, NoPinhole>,
    /// The shift of the rows that it is designed to have besides.
    pub rows: Option<RowShift>,
    /// The shift of the rows that an epipolar design has.
    pub epipolar_rows: Option<RowShift>,
    /// Detected corners with their places on the board; none where the lattice could not be anchored.
    pub found: Vec<Found>,
    /// The exact corners, where they are known.
    pub truth: Option<TrueCorners>,
    /// How they compare.
    pub detected: Detected,
}

/// How the place of a board is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BoardPlace {
    /// The scene gives it.
    Given,
    /// Fitted to the corners.
    Fitted,
    /// Not at all: what was measured holds for the picture alone.
    Unknown,
}

/// A board seen in both halves.
#[derive(Debug, Clone)]
pub struct BoardView {
    /// Distance of the board's centre from the camera along z, in mm.
    pub depth_mm: f64,
    /// The board.
    pub board: Board,
    /// How its place is known.
    pub place: BoardPlace,
    /// Left and right.
    pub halves: [HalfView; 2],
    /// Why the halves of a photograph are not matched, where they are not.
    pub unmatched: Option<NotJudged>,
}

/// What a detector, ours or another, says of a half.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct DetectedLattice {
    /// Corners, in the half's own px.
    pub corners: Vec<LatticeCorner>,
    /// Candidates that were turned down, by reason.
    pub rejected: BTreeMap<String, usize>,
    /// Estimated blur of the picture along the two families of lines, in px.
    pub blur_px: Option<[f64; 2]>,
}

impl From<&Detection> for DetectedLattice {
    fn from(detection: &Detection) -> Self {
        Self {
            corners: detection.corners.iter().map(LatticeCorner::from).collect(),
            rejected: detection.counts().into_iter().map(|(reason, n)| (reason.name().to_owned(), n)).collect(),
            blur_px: detection.sigma_px,
        }
    }
}

/// Detects the board of `system` in both halves of `picture` (linear radiance) and places its corners: [`place`].
///
/// `observer` hears what is done next.
pub fn see(system: &System, picture: &Raster<f32>, own: bool, observer: &dyn Observer) -> BoardView {
    place(system, &detect(system, picture, observer), own, observer)
}

/// What the detector finds in both halves of `picture` (linear radiance), each seen through its own side of `system`'s prism.
pub fn detect(system: &System, picture: &Raster<f32>, observer: &dyn Observer) -> [DetectedLattice; 2] {
    observer.stage("detect");
    Half::BOTH.map(|half| {
        let h = HalfImage::cut(picture, half);
        let mask = own_side(system, &HalfFrame::new(system, h.half));
        DetectedLattice::from(&vision::detect(&h.image, mask.as_ref(), &vision::Settings::default()))
    })
}

/// Gives every corner of the left and the right half its place on the board; with the exact corners beside them when
/// the picture is one that `system` made (`own`).
pub fn place(system: &System, lattices: &[DetectedLattice; 2], own: bool, observer: &dyn Observer) -> BoardView {
    observer.stage("truth");
    let light = InLight::new(system);
    let aimer = own.then(|| Aimer::new(system));
    let halves = [(Half::Left, &lattices[0]), (Half::Right, &lattices[1])].map(|(half, lattice)| {
        let frame = HalfFrame::new(system, half);
        let anchored = anchor(&light, &frame, &lattice.corners);
        let truth = aimer.as_ref().and_then(|aimer| truth::corners(system, aimer, &frame));
        let detected = compare(anchored.as_deref(), truth.as_ref(), lattice);
        HalfView::new(system, frame, anchored.unwrap_or_default(), truth, detected)
    });
    BoardView::new(system, halves, BoardPlace::Given)
}

impl BoardView {
    fn new(system: &System, halves: [HalfView; 2], place: BoardPlace) -> Self {
        let depth_mm = system.board().pattern.world_from_board.translation_mm.z - system.camera().position_mm().z;
        Self { depth_mm, board: *system.board(), place, halves, unmatched: None }
    }

    /// A picture that `system` did not make, whose corners `found` have their places already: without truth.
    pub(super) fn of_photograph(
        system: &System,
        lattices: &[DetectedLattice; 2],
        found: [Vec<Found>; 2],
        place: BoardPlace,
    ) -> Self {
        let [left, right] = found;
        let halves = [(Half::Left, &lattices[0], left), (Half::Right, &lattices[1], right)];
        let halves = halves.map(|(half, lattice, found)| {
            let frame = HalfFrame::new(system, half);
            let detected = compare(Some(&found), None, lattice);
            HalfView::new(system, frame, found, None, detected)
        });
        Self::new(system, halves, place)
    }
}

/// The pixels of a half whose rays go through its own side of the prism, where some do not: the ridge's image is not
/// the middle of the picture when the prism is shifted or tilted, and no lattice may grow across it. Known from the
/// instrument, not from the picture's board. `None` where all pixels do, as judged along the half's border.
pub(super) fn own_side(system: &System, frame: &HalfFrame) -> Option<Raster<bool>> {
    let (width, height) = (frame.size_px.x as usize, frame.size_px.y as usize);
    let own = |i: usize, j: usize| {
        let px = frame.full(DVec2::new(i as f64 + 0.5, j as f64 + 0.5));
        system.exit_ray(px).is_ok_and(|(_, side)| side == frame.side())
    };
    let border =
        (0..width).flat_map(|i| [(i, 0), (i, height - 1)]).chain((0..height).flat_map(|j| [(0, j), (width - 1, j)]));
    if width == 0 || border.into_iter().all(|(i, j)| own(i, j)) {
        return None;
    }
    let rows: Vec<Vec<bool>> = (0..height).into_par_iter().map(|j| (0..width).map(|i| own(i, j)).collect()).collect();
    Some(Raster::from_data(width, height, rows.concat()))
}

fn compare(anchored: Option<&[Found]>, truth: Option<&TrueCorners>, lattice: &DetectedLattice) -> Detected {
    let mut detected = Detected {
        visible: truth.map(|t| t.values().filter(|t| t.whole).count()),
        found: 0,
        partial: 0,
        // A lattice without a place on the board is all wrong.
        wrong: truth.map(|_| if anchored.is_none() { lattice.corners.len() } else { 0 }),
        errors_px: Vec::new(),
        lattice: lattice.corners.len(),
        rejected: lattice.rejected.clone(),
        blur_px: lattice.blur_px,
    };
    let Some(truth) = truth else {
        detected.found = lattice.corners.len();
        return detected;
    };
    for f in anchored.unwrap_or_default() {
        let step = |d: [i32; 2]| {
            let there = truth.get(&[f.index[0] + d[0], f.index[1] + d[1]])?;
            Some(there.position_px.distance(truth.get(&f.index)?.position_px))
        };
        let square_px = [[1, 0], [-1, 0], [0, 1], [0, -1]].into_iter().filter_map(step).fold(f64::INFINITY, f64::min);
        match truth.get(&f.index) {
            // A corner without a neighbour has no square to measure by, and no detector finds it on its own.
            Some(t) if square_px.is_finite() && f.position_px.distance(t.position_px) < SAME_CORNER * square_px => {
                if t.whole {
                    detected.found += 1;
                } else {
                    detected.partial += 1;
                }
                detected.errors_px.push(f.position_px - t.position_px);
            }
            _ => detected.wrong = detected.wrong.map(|n| n + 1),
        }
    }
    detected
}

impl Detected {
    /// Sizes of the detector's errors, where there are any.
    pub fn deviation(&self) -> Option<Deviation> {
        Deviation::of(&self.errors_px).ok()
    }
}

impl HalfView {
    fn new(
        system: &System,
        frame: HalfFrame,
        found: Vec<Found>,
        truth: Option<TrueCorners>,
        detected: Detected,
    ) -> Self {
        let camera = virtual_camera(system, &frame);
        let (rows, epipolar_rows) = (row_shift(system, &frame), epipolar_shift(system, &frame));
        Self { frame, taken_by: *system.camera(), camera, rows, epipolar_rows, found, truth, detected }
    }

    /// Rectified positions by board index: detected ones, and the exact positions of the same corners where they are known, so
    /// that two figures differ only by the detector's error.
    pub fn positions(&self) -> [Option<BTreeMap<[i32; 2], DVec2>>; 2] {
        let found = self.found.iter().map(|f| (f.index, self.rectified(f.position_px))).collect();
        let exact = self.truth.as_ref().map(|truth| {
            let same =
                self.found.iter().filter_map(|f| Some((f.index, self.rectified(truth.get(&f.index)?.position_px))));
            same.collect::<BTreeMap<_, _>>()
        });
        // Where nothing was found, the truth still says what could have been.
        let all =
            |truth: &TrueCorners| truth.iter().map(|(&index, t)| (index, self.rectified(t.position_px))).collect();
        let exact = if self.found.is_empty() { self.truth.as_ref().map(all) } else { exact };
        [Some(found), exact]
    }

    /// Where the plain pinhole in place of the camera would see what it sees at `half_px`: see [`HalfFrame::rectified`].
    pub fn rectified(&self, half_px: DVec2) -> DVec2 {
        self.frame.rectified(&self.taken_by, half_px)
    }

    /// Where the half shows `point_mm` of the world if it is the camera that it is designed to be, seen by the camera that took
    /// it; `None` without such a camera, or behind it.
    pub fn ideal_px(&self, point_mm: DVec3) -> Option<DVec2> {
        let pinhole_px = self.camera.ok()?.project(point_mm)?;
        let designed_px = self.rows.map_or(pinhole_px, |rows| rows.applied(pinhole_px));
        self.frame.unrectified(&self.taken_by, designed_px)
    }

    /// [`HalfView::positions`] as observations of points of `board` in the world.
    pub fn observations(&self, board: &Board) -> [Option<Vec<Observation>>; 2] {
        let point = |[column, row]: [i32; 2]| board.world(board.corner_at(f64::from(column), f64::from(row)));
        self.positions().map(|side| {
            let of = |(&index, &image_px): (&[i32; 2], &DVec2)| Observation { point_mm: point(index), image_px };
            side.map(|positions| positions.iter().map(of).collect())
        })
    }

    /// [`HalfView::positions`] as corners of a grid.
    pub fn indexed(&self) -> [Option<Vec<IndexedCorner>>; 2] {
        let corner = |(index, image_px)| IndexedCorner { index, image_px };
        self.positions().map(|side| side.map(|positions| positions.into_iter().map(corner).collect()))
    }
}
