//! `biprism analyse paper`: every figure and table of the design paper on its own instrument, as one page.

use super::common::{self, StudiedPrism, marches, settings, write_with};
use crate::analysis::convergence::plans;
use crate::analysis::half_image::HalfFrame;
use crate::analysis::paper_claims::{OperandSpot, PaperFindings, claims};
use crate::analysis::relay::study::{PAPER, RelayHalf};
use crate::analysis::reprojection_study::errors;
use crate::analysis::surface_fits::degree_fits;
use crate::analysis::tolerance::operand::Operand;
use crate::analysis::tolerance::probe::{Criterion, Probe};
use crate::analysis::tolerance::sensitivity::{OperandSensitivity, sensitivities};
use crate::analysis::{cutter, layout};
use crate::cli::compare::paper_prisms;
use crate::cli::origin;
use crate::cli::outcome::Outcome;
use crate::cli::progress::Progress;
use crate::cli::set_args::SetArgs;
use crate::cli::study_args::{PAPER_STEP_UM, PaperArgs};
use crate::design::angle::facet_angle_rad;
use crate::error::Error;
use crate::progress::Observer;
use crate::render::{Outputs, render_wanted};
use crate::report::study::contrasts::{self, NamedContrasts};
use crate::report::study::convergences;
use crate::report::study::document::StudyDocument;
use crate::report::study::foci::{self, NamedFoci};
use crate::report::study::layouts::{self, NamedLayout};
use crate::report::study::paper_page::{self, ItemFigures};
use crate::report::study::reprojections::{self, NamedReprojections};
use crate::report::study::spots::{self, NamedSpots};
use crate::report::study::surfaces::{self, NamedFits, NamedSurfaces};
use crate::report::study::tolerances::{self, NamedSensitivities};
use crate::system::Side;
use crate::vision::half::Half;
use serde_json::json;

/// Rings of the pupil of the spots of Table 2.
const RINGS: usize = 16;
/// What the errors of Table 2 cost: its spot, and what a stereo pair is judged by.
const CRITERIA: [Criterion; 3] = [Criterion::Spot, Criterion::Vertical, Criterion::Pinhole];
/// Rays along each side of the grid of Table 1.
const GRID: usize = 33;
/// Degrees of the polynomials of Fig. 4(b): the paper's, and one that does not end where that does.
const DEGREES: [usize; 2] = [5, 9];

pub(crate) fn paper(args: &PaperArgs) -> Result<Outcome, Error> {
    let progress = Progress::new(0);
    let prisms = common::built(paper_prisms(&SetArgs::default())?, &progress)?;
    let scene = &prisms[0].judged.scene;

    // Look at the instruments, item by item.
    progress.begin("paper", "picture");
    let picture = |prism: &StudiedPrism| render_wanted(&prism.system, Outputs { truth: false }, &()).radiance;
    let pictures: Vec<_> = prisms.iter().map(|prism| (prism.judged.name.clone(), picture(prism))).collect();
    progress.begin("paper", "design");
    let plans = plans(PAPER_STEP_UM, args.finest_um.min(PAPER_STEP_UM));
    let rows = marches(scene, plans, &DEGREES, &progress.watch("paper"))?;
    progress.begin("paper", "rays");
    let surfaces = surface_figures(&prisms)?;
    let reprojections = reprojection_of(&prisms)?;
    let (spots, foci, contrasts) = relay_of(&prisms)?;
    let layouts = prisms.iter().map(|prism| {
        let layout = prism.named(layout::layout(&prism.system))?;
        Ok(NamedLayout { prism: prism.judged.name.clone(), layout })
    });
    let layouts = layouts.collect::<Result<Vec<_>, Error>>()?;
    let tolerances = tolerances_of(&prisms[1], &progress)?;

    // Hold them against what the paper prints.
    let glass = scene.prism.body().map_or(1.0, |body| body.index / body.outer_index);
    let half_image_um = |spots: &NamedSpots| {
        spots.study.half_image.as_ref().map_or(f64::NAN, |spot| 1e3 * PAPER.lens.magnification * spot.rms_mm)
    };
    let mean_mm = |one: &NamedReprojections| one.planes[0].deviation.mm.mean_abs.to_array();
    let found = claims(&PaperFindings {
        facet_angle_deg: facet_angle_rad(glass, scene.camera.half_centre_rad())?.to_degrees(),
        table_1_mm: [mean_mm(&reprojections[0]), mean_mm(&reprojections[1])],
        misses: rows
            .iter()
            .filter(|row| row.miss.degree == DEGREES[0])
            .map(|row| (row.plan.integrator, row.miss))
            .collect(),
        spots_um: [half_image_um(&spots[0]), half_image_um(&spots[1])],
        table_2_ideal_um: tolerances.right[0],
        table_2: operand_spots(&tolerances),
    });
    let lens = PAPER.lens;
    let part = |item, figures| ItemFigures { item, figures };
    let parts = [
        part("Fig. 1", vec![paper_page::pictures(&pictures)]),
        part("Fig. 4(a)", surfaces),
        part("Fig. 4(b)", convergences::figures(&scene.name, &rows)),
        part("Fig. 5 and Table 1", reprojections::figures(&reprojections)),
        part("Fig. 6", layouts::figures(&layouts)),
        part("Fig. 7", spots::figures(&lens, &spots)),
        part("Fig. 8", foci::figures(&foci)),
        part("Fig. 9", contrasts::figures(&contrasts)),
        part("Table 2", tolerances::figures(&[tolerances], &CRITERIA)),
    ];
    drop(progress);

    // Write the page, and its figures also by themselves.
    let page = paper_page::html(&found, &parts, &origin::origin());
    let settings = settings([("finest_um", json!(args.finest_um))]);
    let figures = parts.into_iter().flat_map(|part| part.figures).collect();
    let document = StudyDocument { name: "paper", settings, sheets: vec![paper_page::sheet(&found)], figures };
    write_with(&args.out, args.json, &document, &page)
}

/// What each error of Table 2 costs the freeform prism.
fn tolerances_of(freeform: &StudiedPrism, progress: &Progress) -> Result<NamedSensitivities, Error> {
    let probe = freeform.named(Probe::new(&freeform.judged.scene, PAPER.lens, RINGS, None))?;
    let operands: Vec<(Operand, f64)> = Operand::TABLE_2.iter().map(|operand| (*operand, operand.usual())).collect();
    let watch = progress.watch("paper");
    watch.stage_of("errors", operands.len());
    let right = probe.figures(&probe.scene, &CRITERIA).map_err(|why| {
        Error::new("the freeform prism", format!("it has no figure: {}", why.0), "use the paper's own scene")
    })?;
    let errors = sensitivities(&probe, &operands, &CRITERIA, &[], &|| watch.pixels(1));
    Ok(NamedSensitivities { prism: freeform.judged.name.clone(), right, errors })
}

/// The spots of the worse sign, as Table 2 has them.
fn operand_spots(found: &NamedSensitivities) -> Vec<OperandSpot> {
    let spot = |error: &OperandSensitivity| {
        let (operand, surface) = error.operand.name().split_once(' ')?;
        let spot_um = error.figures.iter().flatten().map(|figures| figures[0]).fold(f64::NAN, f64::max);
        Some(OperandSpot { operand, surface, spot_um })
    };
    found.errors.iter().filter_map(spot).collect()
}

/// The right halves' surfaces and their fits.
fn surface_figures(prisms: &[StudiedPrism]) -> Result<Vec<crate::report::study::document::StudyFigure>, Error> {
    let (mut found, mut fits) = (Vec::new(), Vec::new());
    for prism in prisms {
        let name = &prism.judged.name;
        let surfaces = prism.named(cutter::surfaces(&prism.system, Side::Right))?;
        found.push(NamedSurfaces { prism: name.clone(), half: "right", surfaces });
        fits.push(NamedFits { prism: name.clone(), fits: prism.named(degree_fits(&prism.judged.scene))? });
    }
    Ok(surfaces::figures(&found, &fits))
}

fn reprojection_of(prisms: &[StudiedPrism]) -> Result<Vec<NamedReprojections>, Error> {
    let one = |prism: &StudiedPrism| {
        let planes = prism.named(errors(&prism.judged.scene, &prism.system, Half::Right, GRID, &[]))?;
        let size_px = HalfFrame::new(&prism.system, Half::Right).size_px;
        Ok(NamedReprojections { prism: prism.judged.name.clone(), half: "right", size_px, planes })
    };
    prisms.iter().map(one).collect()
}

type OfRelay = (Vec<NamedSpots>, Vec<NamedFoci>, Vec<NamedContrasts>);

/// What the ideal lens behind the right halves finds.
fn relay_of(prisms: &[StudiedPrism]) -> Result<OfRelay, Error> {
    let (mut spots, mut foci, mut contrasts) = OfRelay::default();
    for studied in prisms {
        let half = studied.named(RelayHalf::new(&studied.system, Side::Right, PAPER))?;
        let prism = || studied.judged.name.clone();
        spots.push(NamedSpots { prism: prism(), half: "right", study: studied.named(half.spot())? });
        let lines = studied.named(half.foci())?;
        foci.push(NamedFoci { prism: prism(), half: "right", focus_mm: half.focus_mm, lines });
        contrasts.push(NamedContrasts { prism: prism(), half: "right", study: studied.named(half.mtf())? });
    }
    Ok((spots, foci, contrasts))
}
