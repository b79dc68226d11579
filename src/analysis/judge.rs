//! The judgement of one prism: how far a stereo pair taken through it is from two ideal pinhole cameras.

use super::half_image::HalfFrame;
use super::view::{BoardView, Detected, HalfView, see};
use crate::geom::{Pose, Ray};
use crate::metrics::epipolar::Summary;
use crate::metrics::pixel_map::DEGREE;
use crate::metrics::ray_bundle::{
    CommonPoint, PixelRay, PlaneDeviation, RayMisses, common_point, misses, on_plane, rays_from_depths,
};
use crate::metrics::reprojection::{POSE, POSE_AND_ANAMORPHIC, POSE_AND_FOCAL, Parameter, PinholeFit};
use crate::metrics::stereo::{DepthLaw, Disparity};
use crate::metrics::straightness::{IndexedCorner, RowsAndColumns, StraightnessReference, straightness};
use crate::metrics::{Deviation, MeasuredAndTrue, Observation, Pair, Unmeasurable, epipolar, reprojection, stereo};
use crate::optics::fate::Fate;
use crate::progress::Observer;
use crate::raster::Raster;
use crate::render::{self, Class, Film};
use crate::scene::Scene;
use crate::system::System;
use crate::system::aim::Aimer;
use glam::{DVec2, DVec3};
use std::collections::BTreeMap;

/// Deviation from the designed virtual camera at one depth.
#[derive(Debug, Clone, PartialEq)]
pub struct DepthFigures {
    /// Distance of the board's centre from the camera along z, in mm.
    pub depth_mm: f64,
    /// Without a fit, in px.
    pub designed: MeasuredAndTrue<Deviation>,
    /// With the centre of projection fitted to this depth alone ([`CENTRE_ONLY`]), in px.
    pub fitted: MeasuredAndTrue<Deviation>,
    /// How far that centre lies from the designed one, in mm, and the count of corners behind it.
    pub drift_mm: MeasuredAndTrue<(f64, usize)>,
    /// Straightness of rows and columns, against chords.
    pub straightness: MeasuredAndTrue<RowsAndColumns>,
}

/// Deviation of one half, or of both pooled, from an ideal pinhole.
#[derive(Debug, Clone, PartialEq)]
pub struct PinholeFigures {
    /// Exit rays of a uniform grid in the plane z = -f of the designed virtual camera: Table 1 of the design paper.
    pub designed: MeasuredAndTrue<PlaneDeviation>,
    /// Against a pinhole fitted over all depths, pose and one focal length free, in px.
    pub fitted: MeasuredAndTrue<Deviation>,
    /// The same with two focal lengths free.
    pub anamorphic: MeasuredAndTrue<Deviation>,
    /// Straightness of rows and columns at the scene's own board, against chords.
    pub straightness: MeasuredAndTrue<RowsAndColumns>,
    /// Depth by depth, nearest first.
    pub depths: Vec<DepthFigures>,
}

/// The rays of one half against one centre of projection.
#[derive(Debug, Clone, PartialEq)]
pub struct CentreFigures {
    /// The designed centre, in mm.
    pub designed_mm: DVec3,
    /// Best common point of the rays behind the prism.
    pub common: MeasuredAndTrue<CommonPoint>,
    /// Distances of the rays from the designed centre.
    pub misses: MeasuredAndTrue<RayMisses>,
}

/// Figures of the pair.
#[derive(Debug, Clone, PartialEq)]
pub struct StereoFigures {
    /// Vertical disparity on the raw halves at the scene's own board.
    pub disparity: MeasuredAndTrue<Disparity>,
    /// Epipolar curves in the right half of pixels of the left half.
    pub epipolar: MeasuredAndTrue<Summary>,
    /// Disparity against depth.
    pub depth_law: MeasuredAndTrue<DepthLaw>,
}

/// The judgement of one prism.
#[derive(Debug, Clone)]
pub struct Judgement {
    /// The scene's own board.
    pub view: BoardView,
    /// Detection in the left and the right half.
    pub detected: [Detected; 2],
    /// Left and right against their pinholes.
    pub halves: [PinholeFigures; 2],
    /// Both pooled.
    pub pooled: PinholeFigures,
    /// The centres of projection of left and right, where the virtual camera is known.
    pub centres: [Option<CentreFigures>; 2],
    /// The pair.
    pub stereo: StereoFigures,
    /// Nearest and farthest depth of the analysis, in mm.
    pub depths_mm: Option<[f64; 2]>,
}

/// What a fit at a single depth leaves free: a board that faces the camera does not tell its distance from the focal
/// length, nor a small turn from a shift.
pub const CENTRE_ONLY: [Parameter; 3] = [Parameter::ShiftX, Parameter::ShiftY, Parameter::ShiftZ];
/// Pixels along each side of a half whose epipolar curves are traced.
const CURVES: usize = 9;
/// Samples on each traced epipolar curve.
const SAMPLES: usize = 16;

/// Renders the scene's board, and the board at every depth of the analysis, and judges what `system` made of them.
/// `observer` hears what is done next, and how many pixels were rendered.
pub fn judge(scene: &Scene, system: &System, observer: &dyn Observer) -> (Film, Judgement) {
    let look = |system: &System| {
        observer.stage("render");
        let film = render::render(system, observer);
        let view = see(system, &film.radiance, true, observer);
        (film, view)
    };
    let (film, own) = look(system);
    let others: Vec<BoardView> = scene
        .analysis
        .depths_mm
        .iter()
        .filter(|&&depth_mm| other_depth(depth_mm, own.depth_mm))
        .map(|&depth_mm| look(&at_depth(scene, system, depth_mm)).1)
        .collect();
    observer.stage("measure");
    let judgement = measure(scene, system, own, &others);
    (film, judgement)
}

/// The figures of the scene's own board `own`, with those of the boards at other depths.
pub fn measure(scene: &Scene, system: &System, own: BoardView, others: &[BoardView]) -> Judgement {
    let mut asked: Vec<&BoardView> = others.iter().chain([&own]).collect();
    asked.sort_by(|a, b| a.depth_mm.total_cmp(&b.depth_mm));
    let halves = [0, 1].map(|k| half_figures(scene, system, k, &own, &asked));
    let pooled = pool(&halves, &own, &asked);
    let centres = [0, 1].map(|k| centre_figures(scene, system, k, &own, &asked));
    let stereo = stereo_figures(scene, system, &own, &asked);
    let depths_mm = Some([asked[0].depth_mm, asked[asked.len() - 1].depth_mm]);
    let detected = own.halves.each_ref().map(|h| h.detected.clone());
    Judgement { detected, halves, pooled, centres, stereo, depths_mm, view: own }
}

/// How the rays of the picture's pixels ended, those that met the board's plane left out.
pub fn fates(classes: &Raster<Class>) -> BTreeMap<&'static str, usize> {
    let count = |fate: Fate| classes.data().iter().filter(|&&c| c == Class::from(fate)).count();
    // Only scenes that ask for clipping know of it.
    let known = Fate::ALL.into_iter().filter(|&fate| fate != Fate::Clipped || count(fate) > 0);
    known.map(|fate| (fate.name(), count(fate))).collect()
}

/// Whether two depths differ by more than rounding.
pub fn other_depth(a_mm: f64, b_mm: f64) -> bool {
    (a_mm - b_mm).abs() > 1e-9 * (a_mm.abs() + b_mm.abs())
}

/// The same instrument with the board moved along z to `depth_mm` from the camera.
fn at_depth(scene: &Scene, system: &System, depth_mm: f64) -> System {
    let mut board = scene.board;
    board.world_from_board.translation_mm.z = scene.camera.position_mm.z + depth_mm;
    system.with_board(&board)
}

/// A metric of both sides of what a half gives, where its virtual camera is known.
fn both<I, T>([measured, exact]: [Option<I>; 2], metric: impl Fn(I) -> Result<T, Unmeasurable>) -> MeasuredAndTrue<T> {
    MeasuredAndTrue::of(measured, exact, metric)
}

fn half_figures(scene: &Scene, system: &System, k: usize, own: &BoardView, asked: &[&BoardView]) -> PinholeFigures {
    let half = &own.halves[k];
    let straight = |view: &BoardView| {
        both(view.halves[k].indexed(), |corners| straightness(&corners, StraightnessReference::Chord))
    };
    let Some(camera) = half.camera else {
        let depths = asked.iter().map(|view| DepthFigures {
            depth_mm: view.depth_mm,
            designed: MeasuredAndTrue::NEITHER,
            fitted: MeasuredAndTrue::NEITHER,
            drift_mm: MeasuredAndTrue::NEITHER,
            straightness: straight(view),
        });
        return PinholeFigures {
            designed: MeasuredAndTrue::NEITHER,
            fitted: MeasuredAndTrue::NEITHER,
            anamorphic: MeasuredAndTrue::NEITHER,
            straightness: straight(own),
            depths: depths.collect(),
        };
    };
    let fitted = |free: &[Parameter]| {
        // A single depth does not tell focal lengths from distances: there the pose alone is fitted.
        let free = free_at(free, asked.len());
        let fit = |o: Vec<Observation>| Ok(reprojection::fit(&camera, free, &o)?.deviation);
        both(observations_of_all(asked, k), fit)
    };
    let plane = |sightings: Vec<PixelRay>| on_plane(&camera, &sightings, -scene.camera.focal_length_mm);
    let depth = |view: &&BoardView| {
        let observed = view.halves[k].observations(&view.board);
        let fit = both(observed.clone(), |o| reprojection::fit(&camera, &CENTRE_ONLY, &o));
        let drift = |f: &PinholeFit| Ok(((f.pinhole.centre_mm() - camera.centre_mm()).length(), f.deviation.n));
        DepthFigures {
            depth_mm: view.depth_mm,
            designed: both(observed, |o| camera.deviation_px(&o)),
            drift_mm: fit.then(drift),
            fitted: fit.then(|f| Ok(f.deviation)),
            straightness: straight(view),
        }
    };
    PinholeFigures {
        designed: sightings(scene, system, k, own, asked).flat_then(plane),
        fitted: fitted(&POSE_AND_FOCAL),
        anamorphic: fitted(&POSE_AND_ANAMORPHIC),
        straightness: straight(own),
        depths: asked.iter().map(depth).collect(),
    }
}

/// What a fit over `depths` depths leaves free of `free`.
pub fn free_at(free: &[Parameter], depths: usize) -> &[Parameter] {
    if depths > 1 { free } else { &POSE }
}

/// The observations of one half at all depths.
fn observations_of_all(asked: &[&BoardView], k: usize) -> [Option<Vec<Observation>>; 2] {
    let by_view: Vec<_> = asked.iter().map(|v| v.halves[k].observations(&v.board)).collect();
    [0, 1]
        .map(|side| by_view.iter().map(|sides| sides[side].clone()).collect::<Option<Vec<_>>>().map(|all| all.concat()))
}

/// The rays of a uniform grid of pixels of a half: measured from the corners at several depths, and traced.
fn sightings(
    scene: &Scene,
    system: &System,
    k: usize,
    own: &BoardView,
    asked: &[&BoardView],
) -> MeasuredAndTrue<Vec<PixelRay>> {
    let half = &own.halves[k];
    let traced = grid_sightings(system, &half.frame, scene.analysis.grid);
    let places: Vec<DVec2> = traced.iter().map(|s| s.image_px).collect();
    let found: Option<Vec<_>> = asked.iter().map(|v| v.halves[k].observations(&v.board)[0].clone()).collect();
    MeasuredAndTrue {
        measured: found.map(|depths| rays_from_depths(&depths, &places, DEGREE)),
        exact: half.truth.is_some().then_some(Ok(traced)),
    }
}

/// The exit rays of a uniform `n` x `n` grid over the half image, borders included, where they pass.
pub fn grid_sightings(system: &System, frame: &HalfFrame, n: usize) -> Vec<PixelRay> {
    let centre = frame.own(frame.centre_px(system));
    let [width, height] = system.camera().size_px().map(|n| n as f64);
    let along = |k: usize| if n < 2 { 0.0 } else { k as f64 / (n - 1) as f64 - 0.5 };
    let places = (0..n).flat_map(|j| (0..n).map(move |i| (i, j)));
    places
        .filter_map(|(i, j)| {
            let image_px = centre + DVec2::new(along(i) * 0.5 * width, along(j) * height);
            // Rays of the seam itself are taken through this half's own side.
            let ray = system.exit_ray_through(frame.full(image_px), frame.side()).ok()?;
            Some(PixelRay { image_px, ray })
        })
        .collect()
}

/// Residuals of both halves together.
fn pool(halves: &[PinholeFigures; 2], own: &BoardView, asked: &[&BoardView]) -> PinholeFigures {
    let [left, right] = halves;
    let weighted = |a: &Deviation, b: &Deviation| Ok(a.pooled(b));
    let straight = |view: &BoardView| {
        // Rows of the two halves are different lines: they get different indices.
        const APART: i32 = 1 << 24;
        let [l, r] = [0, 1].map(|k| view.halves[k].indexed());
        let apart = |c: &IndexedCorner| IndexedCorner { index: c.index.map(|i| i + APART), ..*c };
        let joined = [0, 1].map(|side| {
            let (l, r) = (l[side].as_ref()?, r[side].as_ref()?);
            Some(l.iter().copied().chain(r.iter().map(apart)).collect::<Vec<_>>())
        });
        both(joined, |corners| straightness(&corners, StraightnessReference::Chord))
    };
    let depths = left.depths.iter().zip(&right.depths).zip(asked).map(|((a, b), view)| DepthFigures {
        depth_mm: a.depth_mm,
        designed: a.designed.with(&b.designed, weighted),
        fitted: a.fitted.with(&b.fitted, weighted),
        drift_mm: a.drift_mm.with(&b.drift_mm, |a, b| Ok((a.0.max(b.0), a.1 + b.1))),
        straightness: straight(view),
    });
    PinholeFigures {
        designed: left.designed.with(&right.designed, |a, b| {
            Ok(PlaneDeviation {
                plane_z_mm: a.plane_z_mm,
                residuals_mm: [a.residuals_mm.as_slice(), &b.residuals_mm].concat(),
                mm: a.mm.pooled(&b.mm),
                px: a.px.pooled(&b.px),
            })
        }),
        fitted: left.fitted.with(&right.fitted, weighted),
        anamorphic: left.anamorphic.with(&right.anamorphic, weighted),
        straightness: straight(own),
        depths: depths.collect(),
    }
}

fn centre_figures(
    scene: &Scene,
    system: &System,
    k: usize,
    own: &BoardView,
    asked: &[&BoardView],
) -> Option<CentreFigures> {
    let designed_mm = own.halves[k].camera?.centre_mm();
    let rays = sightings(scene, system, k, own, asked).then(|s| Ok(s.iter().map(|s| s.ray).collect::<Vec<Ray>>()));
    Some(CentreFigures {
        designed_mm,
        common: rays.then(|rays| common_point(rays)),
        misses: rays.then(|rays| misses(rays, designed_mm)),
    })
}

fn stereo_figures(scene: &Scene, system: &System, own: &BoardView, asked: &[&BoardView]) -> StereoFigures {
    let width = own.halves[0].frame.size_px.x;
    let by_depth: Vec<[Option<Vec<Pair>>; 2]> = asked.iter().map(|view| pairs(view)).collect();
    let of_side = |side: usize| by_depth.iter().map(|sides| sides[side].clone()).collect::<Option<Vec<_>>>();
    let law = |depths: Vec<Vec<Pair>>| {
        let disparity = |p: &Pair| p.left_px.x - p.right_px.x;
        let of_view = |(view, pairs): (&&BoardView, &Vec<Pair>)| {
            let sample = |p: &Pair| (view.board.corner_depth_mm(p.index, scene.camera.position_mm.z), disparity(p));
            pairs.iter().map(sample).collect::<Vec<_>>()
        };
        stereo::depth_law(&asked.iter().zip(&depths).flat_map(of_view).collect::<Vec<_>>())
    };
    let measured_curves =
        |depths: Vec<Vec<Pair>>| epipolar::summary(&epipolar::curves_from_depths(&depths, DEGREE)?, width);
    let known = own.halves[0].truth.is_some();
    StereoFigures {
        disparity: both(pairs(own), |p| stereo::disparity(&p)),
        epipolar: MeasuredAndTrue {
            measured: of_side(0).map(measured_curves),
            exact: known.then(|| {
                // At a single depth a curve is a point.
                at_least_two(asked)?;
                let range = [asked[0].depth_mm, asked[asked.len() - 1].depth_mm];
                epipolar::summary(&epipolar_curves(scene, system, &own.halves, range), width)
            }),
        },
        depth_law: both([0, 1].map(of_side), law),
    }
}

fn at_least_two(asked: &[&BoardView]) -> Result<(), Unmeasurable> {
    match asked.len() {
        found @ 0..2 => Err(Unmeasurable::TooFew { what: "depths of the board", found, needed: 2 }),
        _ => Ok(()),
    }
}

/// Corners seen in both halves, detected and exact.
fn pairs(view: &BoardView) -> [Option<Vec<Pair>>; 2] {
    let [left, right] = [0, 1].map(|k| view.halves[k].positions());
    [0, 1].map(|side| {
        let (left, right) = (left[side].as_ref()?, right[side].as_ref()?);
        let pair = |(index, &left_px): (&[i32; 2], &DVec2)| {
            Some(Pair { index: *index, left_px, right_px: *right.get(index)? })
        };
        Some(left.iter().filter_map(pair).collect())
    })
}

/// The exact epipolar curves in the right half of a uniform grid of pixels of the left half: the left pixel's ray,
/// sampled at equal steps of 1/depth over the range of depths, each point aimed at through the right side.
/// Pixels that the right half does not see over the whole range of depths are left out.
fn epipolar_curves(scene: &Scene, system: &System, halves: &[HalfView; 2], [near, far]: [f64; 2]) -> Vec<Vec<DVec2>> {
    let [left, right] = [&halves[0].frame, &halves[1].frame];
    let sightings = grid_sightings(system, left, CURVES);
    let mut curves = vec![Vec::new(); sightings.len()];
    for s in 0..SAMPLES {
        let share = s as f64 / (SAMPLES - 1) as f64;
        let depth_mm = 1.0 / ((1.0 - share) / near + share / far);
        let mut plane = scene.board;
        let place = DVec3::new(0.0, 0.0, scene.camera.position_mm.z + depth_mm);
        plane.world_from_board = Pose { translation_mm: place, ..Pose::IDENTITY };
        let system = system.with_board(&plane);
        let aimer = Aimer::new(&system);
        for (curve, sighting) in curves.iter_mut().zip(&sightings) {
            let seen = system.board().intersect(&sighting.ray).and_then(|(mm, _)| aimer.aim(mm, right.side()));
            curve.extend(seen.ok().map(|full_px| right.own(full_px)).filter(|px| right.contains(*px)));
        }
    }
    curves.retain(|curve| curve.len() == SAMPLES);
    curves
}
