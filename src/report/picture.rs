//! A rendered picture as a file: PNG of the radiance, EXR with the ground truth of every pixel through the prism, or NPY of
//! that truth alone at full precision. PNG and EXR say of which instrument ([`identity`]).

use super::stereo_file::StereoPart;
use super::{identity, stereo_file, truth};
use crate::analysis::fates::fates;
use crate::analysis::stereo_truth::StereoTruth;
use crate::effect::Sensor;
use crate::error::Error;
use crate::io::exr::Channel;
use crate::io::npy::NpyField;
use crate::io::png::{SampleCoding, SamplePacking};
use crate::io::{GAMMA, Notes, exr, npy, png};
use crate::progress::Observer;
use crate::raster::Raster;
use crate::raster::transfer::Transfer;
use crate::render::{AccuracyReport, Class, Counts, Film, Outputs, Strip, render_strips};
use crate::scene::{Encoding, Scene};
use crate::system::in_light::light_name;
use crate::system::{Board, System};
use crate::vision::half::{Half, columns_of};
use glam::DVec2;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::iter::once;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::sync_channel;
use std::thread::Builder;

/// The name's ending in lower case.
fn ending(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default()
}

/// Refuses a name for a picture that [`write()`] could not write.
///
/// # Errors
/// When the name ends in none of .png, .exr and .npy.
pub fn check_name(path: &Path) -> Result<(), Error> {
    match ending(path).as_str() {
        "png" | "exr" | "npy" => Ok(()),
        _ => Err(Error::new(
            path.display(),
            "a picture's name ends in none of .png, .exr and .npy",
            "give --out a name that ends in .png, in .exr, or in .npy for the truth alone",
        )),
    }
}

/// Writes the picture that `system`, the instrument of `scene`, took, as its name's ending asks: .png holds the radiance,
/// .exr also the ground truth, .npy that alone, traced anew. Returns how many pixels were brighter than full scale and are clamped (PNG alone).
///
/// # Errors
/// As [`check_name`], and when the file cannot be written.
pub fn write(path: &Path, scene: &Scene, system: &System, film: &Film) -> Result<usize, Error> {
    write_strips(&PictureFile::plain(path.to_owned()), scene, system, once(Arc::new(Strip::from(film))))
}

/// The same into several files at once, of each the pixels that were clamped.
///
/// # Errors
/// As [`write()`], of the first file that has one.
pub fn write_all(paths: &[PathBuf], scene: &Scene, system: &System, film: &Film) -> Result<Vec<usize>, Error> {
    let strip = Arc::new(Strip::from(film));
    let write =
        |path: &PathBuf| write_strips(&PictureFile::plain(path.clone()), scene, system, once(Arc::clone(&strip)));
    paths.par_iter().map(write).collect::<Vec<_>>().into_iter().collect()
}

/// A file of a picture, and what goes into it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PictureFile {
    /// Its name, whose ending says of which kind it is.
    pub path: PathBuf,
    /// The half that is a picture of its own; the whole picture where there is none.
    pub half: Option<Half>,
    /// Whether EXR and NPY hold what is true of a stereo pair as well.
    pub stereo: bool,
    /// How a PNG is packed.
    pub packing: SamplePacking,
}

impl PictureFile {
    /// The whole picture, without what is true of a stereo pair.
    pub fn plain(path: PathBuf) -> Self {
        Self { path, half: None, stereo: false, packing: SamplePacking::Small }
    }

    /// The files of both halves: `a_left.png` and `a_right.png` of `a.png`.
    #[must_use]
    pub fn halves(&self) -> [Self; 2] {
        Half::BOTH.map(|half| {
            let stem = self.path.file_stem().unwrap_or_default().to_string_lossy();
            let name = format!("{stem}_{}.{}", half.name(), self.path.extension().unwrap_or_default().display());
            Self { path: self.path.with_file_name(name), half: Some(half), ..self.clone() }
        })
    }
}

/// Writes a picture that comes in strips, one below the other, as [`write()`].
///
/// # Errors
/// As [`write()`].
pub fn write_strips(
    file: &PictureFile,
    scene: &Scene,
    system: &System,
    strips: impl Iterator<Item = Arc<Strip>>,
) -> Result<usize, Error> {
    // Cut each strip to the half.
    let PictureFile { path, half, stereo, packing } = file;
    let whole = scene.camera.width_px;
    let columns = half.map_or(0..whole, |half| columns_of(whole, half));
    let cut = |strip: Arc<Strip>| if half.is_some() { Arc::new(strip.columns(columns.clone())) } else { strip };
    let mut strips = strips.map(cut).peekable();

    // Note what the file holds.
    let sampled = strips.peek().is_some_and(|first| first.noise.is_some());
    let json = notes(scene, system, sampled, file);
    let notes = Notes { json: &json, pitch_mm: Some(scene.camera.pitch_mm) };
    let size = (columns.len(), scene.camera.height_px);

    // Count the rows of what is true.
    let rows_of = |done: &mut usize, strip: &Strip| {
        let first = *done;
        *done += strip.radiance.height();
        first..*done
    };
    let truth = StereoTruth::new(system);
    let part = |rows| stereo.then(|| StereoPart::new(&truth, whole, *half, rows));
    match ending(path).as_str() {
        "png" => {
            let transfer = match scene.encoding {
                Encoding::Linear => Transfer::Linear,
                Encoding::Srgb => Transfer::Srgb,
            };
            let coding = SampleCoding { transfer, packing: *packing };
            if strips.peek().is_some_and(|first| first.colour.is_some()) {
                let colours = strips.filter_map(|strip| strip.colour.clone());
                png::write_rgb16_strips(path, size, colours, coding, &notes)
            } else {
                let greys = strips.map(|strip| strip.radiance.clone());
                png::write_grey16_strips(path, size, greys, coding, &notes)
            }
        }
        "exr" => {
            let parts = strips.scan(0, |done, strip| {
                let stereo = part(rows_of(done, &strip));
                let mut all = channels(system, &strip, file);
                all.extend(stereo.iter().flat_map(StereoPart::channels));
                Some(all)
            });
            exr::write_strips(path, size.1, parts, &notes).map(|()| 0)
        }
        "npy" => {
            let rows = strips.scan(0, |done, strip| Some(rows_of(done, &strip)));
            let parts = rows.map(|rows| match part(rows.clone()) {
                Some(stereo) => stereo.records(),
                None => truth::records(&truth, columns.clone(), rows),
            });
            let plain = if *stereo { &stereo_file::FIELDS[..] } else { &truth::FIELDS };
            let objects = truth.has_objects().then_some(truth::OBJECT);
            let fields: Vec<NpyField> = plain.iter().copied().chain(objects).collect();
            npy::write_parts(path, &fields, &[size.1, size.0], parts).map(|()| 0)
        }
        _ => check_name(path).map(|()| 0),
    }
}

/// What is noted in a picture's file, as JSON: scene, instrument, and what each channel is.
fn notes(scene: &Scene, system: &System, sampled: bool, file: &PictureFile) -> String {
    let mut what = serde_json::json!({
        "scene": scene.name,
        "prism": scene.prism.kind(),
        "instrument": identity::parts(scene, system),
        "pixel_centre": "(i + 0.5, j + 0.5)",
        "radiance": radiance_words(system.effects().sensor.as_ref()),
        "Y": "of a colour picture the luminance 0.2126 R + 0.7152 G + 0.0722 B of its channels as they are stored",
        "truth_light": light_name(scene, system),
        "board.U, board.V": "position on the board that the pixel's centre sees, mm in the board's frame, f32",
        "world_from_board": boards(system).map(world_from_board).collect::<Vec<_>>(),
        "class": ["left", "right", "missed", "total_reflection", "not_converged", "past_board"],
    });
    if let Some(sensor) = system.effects().sensor.filter(|sensor| sensor.gamma != 1.0) {
        what[GAMMA] = sensor.gamma.into();
    }
    if system.clips()
        && let Some(classes) = what["class"].as_array_mut()
    {
        classes.push("clipped".into());
    }
    if let Some(half) = file.half {
        what["half"] = half.name().into();
    }
    if file.stereo {
        what["P"] = "the same in the world, mm".into();
        what["stereo"] = STEREO_WORDS.into();
    }
    if sampled {
        what["Y.error"] = "standard error of Y, from the spread of random sets of samples".into();
    }
    what.to_string()
}

/// The board, and the objects before it, in the scene's order.
fn boards(system: &System) -> impl Iterator<Item = &Board> {
    once(system).chain(system.layers()).map(System::board)
}

/// How a position on a board becomes one in the world: origin + u U + v V.
fn world_from_board(board: &Board) -> serde_json::Value {
    let pose = board.pattern.world_from_board;
    let [origin, u, v] = [pose.translation_mm, pose.rotation.x_axis, pose.rotation.y_axis].map(|axis| axis.to_array());
    serde_json::json!({ "origin_mm": origin, "u": u, "v": v })
}

/// What the channels of a stereo pair are.
const STEREO_WORDS: &str = "Z: depth along the camera's axis, mm; distance: from the camera's position, mm; other: where the other \
                            side of the prism sees the same point, px of the whole picture, or of the other half where a half is \
                            a picture of its own; disparity: position in the left half less that in the right one, px of each; \
                            seen_by: 0 nothing is seen, 1 by the left half alone, 2 by the right one alone, 3 by both";

/// What the value of a pixel is, and how a sensor's is made light again.
fn radiance_words(sensor: Option<&Sensor>) -> String {
    let Some(sensor) = sensor.filter(|sensor| !sensor.is_nothing()) else {
        return "mean over the pixel, of full scale 1, linear light".to_owned();
    };
    let side = sensor.active_side();
    let mut words =
        format!("as the sensor reads it out: mean over the square of side {side} px in the middle of the pixel");
    if sensor.gamma != 1.0 {
        let _ = write!(words, "; coded as v^(1/{}), which v^{} undoes", sensor.gamma, sensor.gamma);
    }
    if let Some(adc) = &sensor.adc {
        let dark = (adc.black_level_dn + sensor.dark_e * adc.gain_dn_per_e) / adc.largest_dn();
        let gain = adc.largest_dn() / (adc.gain_dn_per_e * sensor.white_e);
        let _ = write!(words, "; then light of full scale 1 is (v - {dark}) * {gain}");
    } else if sensor.dark_e > 0.0 {
        let _ = write!(words, "; then light of full scale 1 is v - {}", sensor.dark_e / sensor.white_e);
    }
    if sensor.bayer.is_some() {
        words += "; through colour filters";
    }
    words
}

/// Radiance and, for each pixel's centre, what it sees through the prism; in the world as well where the stereo pair is asked for.
fn channels(system: &System, strip: &Strip, file: &PictureFile) -> Vec<Channel> {
    let mut channels = vec![Channel::f32("Y", strip.radiance.clone())];
    if let (Some(classes), Some(board_mm)) = (&strip.class, &strip.board_mm) {
        let planes = (board_mm, classes);
        channels.extend([
            Channel::f32("board.U", where_seen(planes, |_, mm| mm[0])),
            Channel::f32("board.V", where_seen(planes, |_, mm| mm[1])),
            Channel::u32("class", classes.map(|class| class as u32)),
        ]);
        if file.stereo {
            let boards: Vec<_> = boards(system).collect();
            let of = |k: usize| boards[strip.object.as_ref().map_or(0, |object| object.data()[k] as usize)];
            let world =
                |axis: usize| where_seen(planes, |k, mm| of(k).world(DVec2::from(mm.map(f64::from)))[axis] as f32);
            let axes = ["P.X", "P.Y", "P.Z"].into_iter().enumerate();
            channels.extend(axes.map(|(axis, name)| Channel::f32(name, world(axis))));
        }
        channels.extend(strip.object.clone().map(|object| Channel::u32("object", object)));
    }
    if let Some(colour) = &strip.colour {
        for (k, name) in ["R", "G", "B"].into_iter().enumerate() {
            channels.push(Channel::f32(name, colour.map(|pixel| pixel[k])));
        }
    }
    if let Some(noise) = &strip.noise {
        channels.push(Channel::f32("Y.error", noise.clone()));
    }
    channels
}

/// A value of each pixel, by its number and its position on the board, where a side of the prism sees something; else NaN.
fn where_seen(
    (board_mm, classes): (&Raster<[f32; 2]>, &Raster<Class>),
    value: impl Fn(usize, [f32; 2]) -> f32,
) -> Raster<f32> {
    let pixels = board_mm.data().iter().zip(classes.data()).enumerate();
    let seen = pixels.map(|(k, (mm, class))| if class.side().is_some() { value(k, *mm) } else { f32::NAN });
    Raster::from_data(board_mm.width(), board_mm.height(), seen.collect())
}

/// What came of a picture that was rendered into files.
#[derive(Debug, Clone, PartialEq)]
pub struct Written {
    /// How many pixels' rays ended so, by name of the fate.
    pub fates: BTreeMap<&'static str, usize>,
    /// How much work it was.
    pub counts: Counts,
    /// What was promised, and what was found.
    pub account: AccuracyReport,
    /// Of each file, how many pixels were clamped to full scale.
    pub clamped: Vec<usize>,
}

/// Renders the picture of `scene`, whose instrument is `system`, strip by strip into all the files at once, as [`write_strips`]: of
/// each file a thread writes one strip while the next is made, so that few strips are held at a time. `observer` hears how
/// many more pixels are done.
///
/// # Errors
/// As [`write()`].
pub(crate) fn render_to_files<'env>(
    files: &'env [PictureFile],
    scene: &'env Scene,
    system: &'env System,
    observer: &dyn Observer,
) -> Result<Written, Error> {
    std::thread::scope(|scope| {
        let writer = |file: &'env PictureFile| {
            let (strips, received) = sync_channel::<Arc<Strip>>(1);
            let write = move || write_strips(file, scene, system, received.into_iter());
            let thread = Builder::new().spawn_scoped(scope, write).map_err(|error| {
                let rule = format!("no thread can be made to write it: {error}");
                Error::new(file.path.display(), rule, "write fewer files at once, or end other programs")
            })?;
            Ok((strips, thread))
        };
        let writers = files.iter().map(writer).collect::<Result<Vec<_>, Error>>()?;
        let mut all_fates = BTreeMap::new();
        // NPY traces the truth anew.
        let wanted = Outputs { truth: files.iter().any(|file| ending(&file.path) == "exr") };
        let (counts, account) = render_strips(system, wanted, observer, &mut |strip| {
            strip.class.iter().flat_map(fates).for_each(|(fate, n)| *all_fates.entry(fate).or_insert(0) += n);
            let strip = Arc::new(strip);
            for (strips, _) in &writers {
                // A writer that takes no more has met a problem, which is told below.
                let _ = strips.send(Arc::clone(&strip));
            }
        });
        let finish = |(strips, writer): (_, std::thread::ScopedJoinHandle<'_, _>)| {
            drop(strips);
            writer.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
        };
        let clamped = writers.into_iter().map(finish).collect::<Result<_, _>>()?;
        Ok(Written { fates: all_fates, counts, account, clamped })
    })
}
