//! The threads that make pictures: each makes whole pictures by itself, so that few are held at a time and none waits for another.

use super::manifest_file::ManifestFile;
use crate::analysis::corners_on_board;
use crate::analysis::dataset::{Dataset, DatasetPose};
use crate::analysis::half_image::HalfFrame;
use crate::analysis::truth::TrueCorners;
use crate::cli::files;
use crate::error::Error;
use crate::io::corners::{CornerFormat, CornerView, ListedCorner, to_text};
use crate::io::png::SamplePacking;
use crate::progress::Observer;
use crate::render::{Film, Outputs, Strip, render_wanted};
use crate::report::dataset::{LookCounts, PoseLine, SetFiles};
use crate::report::design;
use crate::report::picture::{PictureFile, write_strips};
use crate::scene;
use crate::vision::half::Half;
use std::iter::once;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{Builder, scope};

/// What pictures are made of.
pub(super) struct Workshop<'a> {
    pub(super) set: &'a Dataset,
    pub(super) files: SetFiles,
    /// The folder.
    pub(super) out: &'a Path,
    /// The text of the scene, and how it is called in messages.
    pub(super) scene_text: &'a str,
    pub(super) scene_place: &'a str,
}

impl Workshop<'_> {
    /// Makes the pictures of these numbers and notes them in `manifest`.
    ///
    /// # Errors
    /// The fault of the picture of the smallest number that could not be made.
    pub(super) fn make_all(
        &self,
        numbers: &[u32],
        manifest: ManifestFile,
        watch: &dyn Observer,
    ) -> Result<ManifestFile, Error> {
        let manifest = Mutex::new(manifest);
        let (next, stopped) = (AtomicUsize::new(0), AtomicBool::new(false));
        let fault: Mutex<Option<(u32, Error)>> = Mutex::new(None);
        let work = || {
            // What a picture does in parallel is done by its own thread: pictures are enough to keep all of them busy.
            let alone = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build();
            while let Some(&number) = numbers.get(next.fetch_add(1, Ordering::Relaxed)) {
                if stopped.load(Ordering::Relaxed) {
                    break;
                }
                let noted = self
                    .make(number)
                    .and_then(|line| manifest.lock().unwrap_or_else(PoisonError::into_inner).done(line));
                match noted {
                    Ok(()) => watch.pixels(1),
                    Err(problem) => {
                        stopped.store(true, Ordering::Relaxed);
                        let mut fault = fault.lock().unwrap_or_else(PoisonError::into_inner);
                        if fault.as_ref().is_none_or(|(earlier, _)| number < *earlier) {
                            *fault = Some((number, problem));
                        }
                    }
                }
            }
            drop(alone);
        };
        scope(|scope| {
            let threads = rayon::current_num_threads().min(numbers.len());
            let started: Vec<_> = (0..threads).map_while(|_| Builder::new().spawn_scoped(scope, work).ok()).collect();
            if started.is_empty() {
                work();
            }
        });
        match fault.into_inner().unwrap_or_else(PoisonError::into_inner) {
            Some((_, problem)) => Err(problem),
            None => Ok(manifest.into_inner().unwrap_or_else(PoisonError::into_inner)),
        }
    }

    /// Makes the files of one picture. Returns its line of the manifest.
    fn make(&self, number: u32) -> Result<PoseLine, Error> {
        // Take the picture.
        let pose = self.set.pose(number)?;
        let film = render_wanted(&pose.system, Outputs { truth: self.files.truth }, &());
        let kept = design::accuracy(&film.account, &film.counts).unmet().is_empty();

        // Find corners in it.
        let detected = match self.files.detected(number) {
            None => None,
            Some(name) => {
                let views = corners_on_board::detected(&pose.system, &pose.system.effects().decoded(&film.radiance));
                self.write(&name, &to_text(&views, CornerFormat::Csv))?;
                Some(views.each_ref().map(|view| view.corners.len()))
            }
        };

        // Write it, and what is true of it.
        let clamped_px = self.write_pictures(&pose, film)?;
        let halves = [0, 1].map(|k| listed(&pose, Half::BOTH[k], &pose.corners[k]));
        self.write(&SetFiles::corners(number), &to_text(&halves, CornerFormat::Csv))?;
        let text = scene::replaced(self.scene_text, self.scene_place, &pose.values)?;
        self.write(&SetFiles::scene(number), &text)?;
        let corners = pose.corners.each_ref().map(TrueCorners::len);
        Ok(PoseLine::new(&pose, LookCounts { corners, detected, clamped_px, kept }, self.files.all(number)))
    }

    fn write(&self, name: &str, text: &str) -> Result<(), Error> {
        files::text(&self.out.join(name), text)
    }

    /// Writes the pictures, and the truth of their pixels where it is asked for. Returns how many pixels are clamped.
    fn write_pictures(&self, pose: &DatasetPose, film: Film) -> Result<usize, Error> {
        let Film { radiance, colour, noise, class, board_mm, object, .. } = film;
        let strip = Arc::new(Strip { radiance, colour, noise, class, board_mm, object });
        let halves: &[Option<Half>] = if self.files.halves { &Half::BOTH.map(Some) } else { &[None] };
        let mut clamped_px = 0;
        for (names, stereo) in [(self.files.pictures(pose.number), false), (self.files.truths(pose.number), true)] {
            for (name, half) in names.into_iter().zip(halves) {
                let file = PictureFile { path: self.out.join(name), half: *half, stereo, packing: SamplePacking::Fast };
                clamped_px += write_strips(&file, &pose.scene, &pose.system, once(Arc::clone(&strip)))?;
            }
        }
        Ok(clamped_px)
    }
}

/// The true corners of a half as a file holds them.
fn listed(pose: &DatasetPose, half: Half, corners: &TrueCorners) -> CornerView {
    let frame = HalfFrame::new(&pose.system, half);
    let corner = |(&index, corner): (&[i32; 2], &crate::analysis::truth::TrueCorner)| ListedCorner {
        index,
        position_px: frame.full(corner.position_px),
        quality: None,
    };
    let mut listed: Vec<ListedCorner> = corners.iter().map(corner).collect();
    listed.sort_by_key(|corner| [corner.index[1], corner.index[0]]);
    CornerView::of_board(half.name(), listed)
}
