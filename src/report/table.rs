//! The short table of two prisms, and the sentence that judges them.

use super::board_pose;
use super::json::{BudgetTerm, Depth, Design, ErrorBudget, Figure};
use super::number::number;
pub use super::number::rounded;
use std::fmt::Write;

/// One row of the table: what, and its figure for a design.
struct TableRow {
    label: &'static str,
    of: fn(&Design) -> Option<&Figure>,
}

/// A row as it is shown.
#[derive(Debug, Clone, PartialEq)]
pub struct Shown {
    /// What it is, with its unit.
    pub label: String,
    /// The same beside [`Shown::short`]: marked where these are true ones.
    pub short_label: String,
    /// "measured | true" for each design, or one word.
    pub values: Vec<String>,
    /// The one number for each design where there is room for one: the measured one; for Table 1, whose grid reaches
    /// beyond the corners, the exact one.
    pub short: Vec<String>,
    /// The figure behind each design's value, with its definition; of a word none.
    pub figures: Vec<Option<Figure>>,
}

const ROWS: [TableRow; 27] = [
    TableRow { label: "vertical disparity, RMS, px", of: |d| Some(&d.stereo.vertical_disparity_rms_px) },
    TableRow { label: "vertical disparity, largest, px", of: |d| Some(&d.stereo.vertical_disparity_max_px) },
    TableRow { label: "  after one homography a half, RMS, px", of: rectified },
    TableRow { label: "epipolar slope, mean, rad", of: |d| Some(&d.stereo.epipolar_slope_mean_rad) },
    TableRow { label: "epipolar slope, largest, rad", of: |d| Some(&d.stereo.epipolar_slope_max_rad) },
    TableRow { label: "  its rise over a half image, px", of: |d| Some(&d.stereo.epipolar_rise_max_px) },
    TableRow { label: "epipolar curve from its line, RMS, px", of: |d| Some(&d.stereo.epipolar_departure_rms_px) },
    TableRow { label: "Table 1 (virtual image plane), mean |H|, mm", of: |d| Some(&d.pinhole.designed.mean_abs_h_mm) },
    TableRow { label: "Table 1 (virtual image plane), mean |V|, mm", of: |d| Some(&d.pinhole.designed.mean_abs_v_mm) },
    TableRow { label: "corners from their designed places, RMS, px", of: of_corners },
    TableRow { label: "corners from fitted pinhole, RMS, px", of: |d| Some(&d.pinhole.fitted.rms_px) },
    TableRow { label: "  with f_x and f_y fitted apart, RMS, px", of: of_anamorphic },
    TableRow { label: "  with the principal point too, RMS, px", of: |d| Some(&d.pinhole.principal.as_ref()?.rms_px) },
    TableRow {
        label: "corners from designed centre by homography, px",
        of: |d| Some(&d.pinhole.homography.as_ref()?.rms_px),
    },
    TableRow {
        label: "corners from fitted row law, RMS in u, px",
        of: |d| Some(&d.pinhole.row_law.as_ref()?.rms_u_px),
    },
    TableRow { label: "  RMS in v, px", of: |d| Some(&d.pinhole.row_law.as_ref()?.rms_v_px) },
    TableRow { label: "  with kappa undone, RMS in u, px", of: |d| Some(&d.pinhole.row_law.as_ref()?.undone_rms_u_px) },
    TableRow { label: "  with kappa undone, RMS in v, px", of: |d| Some(&d.pinhole.row_law.as_ref()?.undone_rms_v_px) },
    TableRow { label: "rows and columns from straight, RMS, px", of: |d| Some(&d.pinhole.straightness_rms_px) },
    TableRow { label: "best centre from designed one, left, mm", of: left_drift },
    TableRow { label: "baseline, mm", of: |d| Some(&d.geometry.as_ref()?.baseline_mm) },
    TableRow { label: "vergence of the central rays, deg", of: |d| Some(&d.geometry.as_ref()?.vergence_deg) },
    TableRow { label: "field of a half, horizontal, deg", of: |d| Some(&d.geometry.as_ref()?.field_h_deg) },
    TableRow { label: "field of a half, vertical, deg", of: |d| Some(&d.geometry.as_ref()?.field_v_deg) },
    TableRow { label: "depth for 1 px of disparity, at the board, mm", of: depth_per_px },
    TableRow { label: "depth by the designed pair, error RMS, mm", of: |d| d.stereo.depth_error_rms_mm.as_ref() },
    TableRow { label: "  of the true depth, %", of: |d| d.stereo.depth_error_rms_percent.as_ref() },
];

/// At the depth nearest to the scene's own board.
fn of_corners(design: &Design) -> Option<&Figure> {
    let own = design.stereo.vertical_disparity_rms_px.depths_mm?[0];
    let from_own = |d: &&Depth| (d.depth_mm - own).abs();
    let nearest = design.pinhole.depths.iter().min_by(|a, b| from_own(a).total_cmp(&from_own(b)));
    nearest.map(|d| &d.designed.rms_px)
}

fn of_anamorphic(design: &Design) -> Option<&Figure> {
    design.pinhole.anamorphic.as_ref().map(|a| &a.rms_px)
}

fn rectified(design: &Design) -> Option<&Figure> {
    design.stereo.rectified_vertical_disparity_rms_px.as_ref()
}

fn depth_per_px(design: &Design) -> Option<&Figure> {
    Some(&design.geometry.as_ref()?.depth_per_px_mm)
}

fn left_drift(design: &Design) -> Option<&Figure> {
    design.halves.left.pinhole.centre.as_ref().map(|c| &c.drift_mm)
}

/// The rows of the table.
pub fn rows(designs: &[Design]) -> Vec<Shown> {
    let of_row = |row: &TableRow| {
        let exact = row.label.starts_with("Table 1");
        let measured = |d: &Design| number((row.of)(d).and_then(|f| f.measured));
        let truth = |d: &Design| number((row.of)(d).and_then(|f| f.exact));
        let mark = |d: &Design| if (row.of)(d).is_some_and(differs) { " !" } else { "" };
        let rests = |d: &Design| if of_pairs(row) && rests_on_match(d) { " *" } else { "" };
        let both = |d: &Design| format!("{} | {}{}{}", measured(d), truth(d), mark(d), rests(d));
        let one = |d: &Design| if exact { truth(d) } else { measured(d) };
        Shown {
            label: row.label.to_owned(),
            short_label: format!("{}{}", row.label, if exact { ", true" } else { "" }),
            values: designs.iter().map(both).collect(),
            short: designs.iter().map(one).collect(),
            figures: designs.iter().map(|d| (row.of)(d).cloned()).collect(),
        }
    };
    let of_word = |label: &str, word: &dyn Fn(&Design) -> String| {
        let values: Vec<String> = designs.iter().map(word).collect();
        let figures = vec![None; designs.len()];
        Shown { label: label.to_owned(), short_label: label.to_owned(), short: values.clone(), values, figures }
    };
    let mut rows: Vec<Shown> = ROWS.iter().map(of_row).collect();
    rows.push(of_word("corners found/fully visible + cut, false", &|d| match d.corners.visible {
        Some(visible) => {
            format!("{}/{visible} + {}, {}", d.corners.found, d.corners.partial, d.corners.spurious.unwrap_or(0))
        }
        None => d.corners.found.to_string(),
    }));
    let smears = smears(designs);
    let label = match &smears[..] {
        [] => "error of the detector, RMS, px".to_owned(),
        _ => format!("found from true corners, with {}, RMS, px", smears.join(" and ")),
    };
    rows.push(of_word(&label, &|d| number(d.corners.rms_error_px)));
    rows
}

/// Whether a row is taken from pairs of corners at the scene's own board.
fn of_pairs(row: &TableRow) -> bool {
    row.label.starts_with("vertical disparity") || row.label.starts_with("depth by the designed pair")
}

/// Whether something other than the whole board in both halves told which corner is which.
fn rests_on_match(design: &Design) -> bool {
    design.matching.as_ref().is_some_and(|matching| !matching.rests.is_empty())
}

/// The effects of all designs that smear edges, each once.
fn smears(designs: &[Design]) -> Vec<&str> {
    let mut smears: Vec<&str> = Vec::new();
    for effect in designs.iter().flat_map(|d| &d.smeared_by) {
        if !smears.contains(&effect.as_str()) {
            smears.push(effect);
        }
    }
    smears
}

/// A measured and a true value that differ by more than this share of the larger are marked; differences below
/// [`UNMARKED`] are the detector's own error.
const MARKED: f64 = 0.1;
const UNMARKED: f64 = 1e-3;

/// Whether the measured and the true value of a row differ by so much that a reader must know.
fn differs(figure: &Figure) -> bool {
    let (Some(measured), Some(exact)) = (figure.measured, figure.exact) else { return false };
    let difference = (measured - exact).abs();
    difference > MARKED * measured.abs().max(exact.abs()) && difference > UNMARKED
}

/// The table as text, with one line of heading.
pub fn text(designs: &[Design]) -> String {
    let rows = rows(designs);
    let width = rows.iter().map(|row| row.label.chars().count()).max().unwrap_or(0);
    let column = rows.iter().flat_map(|row| &row.values).map(String::len).max().unwrap_or(0).max(16);
    let mut text = format!("{:width$}", "measured | true");
    for design in designs {
        let _ = write!(text, "  {:>column$}", design.name);
    }
    for row in rows {
        let _ = write!(text, "\n{:width$}", row.label);
        for value in row.values {
            let _ = write!(text, "  {value:>column$}");
        }
    }
    for line in remarks(designs) {
        let _ = write!(text, "\n{line}");
    }
    for (name, budget) in designs.iter().filter_map(|d| Some((&d.name, d.error_budget.as_ref()?))) {
        let _ = write!(text, "\n{}", crate::report::table::budget_words(name, budget));
    }
    text
}

/// What a reader of the figures must know: why some are missing, what the marks say, where the boards stand, and how the corners
/// of a picture were matched and placed.
pub(crate) fn remarks(designs: &[Design]) -> Vec<String> {
    let missing = reasons(designs).into_iter().map(|reason| format!("-: {reason}"));
    let marked = designs.iter().any(|d| ROWS.iter().filter_map(|row| (row.of)(d)).any(differs)).then(|| {
        "!: the two differ by over 10 %: the measured one holds over the corners found, the true one over all rays"
            .to_owned()
    });
    let matched = designs.iter().filter_map(|d| board_pose::rests(d.matching.as_ref()?));
    let posed = designs.iter().filter_map(|d| board_pose::line(d.board_pose.as_ref()?));
    missing.chain(marked).chain(depths(designs)).chain(light(designs)).chain(matched).chain(posed).collect()
}

/// The distances of the scenes' own boards, each once.
fn own_depths(designs: &[Design]) -> Vec<f64> {
    let mut all: Vec<f64> =
        designs.iter().filter_map(|d| Some(d.stereo.vertical_disparity_rms_px.depths_mm?[0])).collect();
    all.dedup();
    all
}

/// At which distances the boards of the figures stand, the scene's own first; by design where they differ.
pub fn depths(designs: &[Design]) -> Option<String> {
    let mut each: Vec<(&str, String)> =
        designs.iter().filter_map(|design| Some((design.name.as_str(), depths_of(design)?))).collect();
    each.dedup_by(|a, b| a.1 == b.1);
    match &each[..] {
        [] => None,
        [(_, words)] => Some(words.clone()),
        all => Some(all.iter().map(|(name, words)| format!("{name}: {words}")).collect::<Vec<_>>().join("; ")),
    }
}

fn depths_of(design: &Design) -> Option<String> {
    let own = design.stereo.vertical_disparity_rms_px.depths_mm?[0];
    let all: Vec<String> = design.pinhole.depths.iter().map(|depth| rounded(depth.depth_mm)).collect();
    Some(match &all[..] {
        [] | [_] => format!("board at {} mm", rounded(own)),
        all => format!(
            "board at {} mm; pinholes, epipolar curves and Table 1 over boards at {} mm",
            rounded(own),
            all.join(", ")
        ),
    })
}

/// The light in which the true values are true.
fn light(designs: &[Design]) -> Option<String> {
    designs.iter().find_map(|design| Some(format!("true: in {}", design.truth_light.as_ref()?)))
}

/// Why values of the table are missing, each reason once.
fn reasons(designs: &[Design]) -> Vec<&str> {
    let mut reasons: Vec<&str> = Vec::new();
    for reason in designs.iter().flat_map(|d| ROWS.iter().filter_map(|row| (row.of)(d)?.reason.as_deref())) {
        if !reasons.contains(&reason) {
            reasons.push(reason);
        }
    }
    reasons
}

/// What a reader of the table must know besides: corners that are none, and rays that never saw the board.
pub fn warnings(design: &Design) -> Vec<String> {
    let mut warnings = Vec::new();
    if let Some(n) = design.corners.spurious.filter(|n| *n > 0) {
        warnings.push(format!(
            "{}: {n} detected corners are none of the board, and spoil the measured figures",
            design.name
        ));
    }
    for (fate, n) in design.fates.iter().filter(|(_, n)| **n > 0) {
        warnings.push(format!("{}: {n} pixels never see the board: {fate}", design.name));
    }
    warnings
}

/// One sentence on the second design against the first, by the vertical disparity of raw halves. The bands are those
/// of the ROS camera calibrator's tutorial: below 0.25 px acceptable, below 0.1 px excellent.
pub fn verdict(designs: &[Design]) -> String {
    on_disparity(designs) + &on_rows(designs) + &on_detector(designs)
}

/// Where the detector's own error is most of what was measured.
fn on_detector(designs: &[Design]) -> String {
    let limited = |d: &'_ Design| {
        let figure = &d.stereo.vertical_disparity_rms_px;
        let (measured, exact) = (figure.measured?, figure.exact?);
        let above = measured > DETECTABLE_PX && exact < LIMITED * measured;
        above.then(|| {
            format!(
                " Most of what was measured of the {} prism is the error of the corners that were found: truly it leaves {} px.",
                d.name,
                number(Some(exact))
            )
        })
    };
    designs.iter().filter_map(limited).collect()
}

/// A measured disparity above so many px is told to be the detector's where less than this share of it is true.
const DETECTABLE_PX: f64 = 1e-3;
const LIMITED: f64 = 0.5;

/// By how much less a row law must leave with its shift undone for the shift to be what is left of a pinhole.
const UNDONE: f64 = 0.1;

/// What is left of a pinhole in prisms whose rows are shifted by a known amount each, and what when that is undone.
fn on_rows(designs: &[Design]) -> String {
    let found = |d: &'_ Design| {
        let law = d.pinhole.row_law.as_ref()?;
        let [raw, u, v] = [&law.rms_u_px, &law.undone_rms_u_px, &law.undone_rms_v_px].map(|figure| figure.measured);
        Some((d.name.clone(), raw?, u?, v?))
    };
    let shifted: Vec<_> = designs.iter().filter_map(found).filter(|(_, raw, u, _)| *u < UNDONE * raw).collect();
    let px = |px: f64| number(Some(px));
    let each = shifted.iter().map(|(name, raw, u, v)| {
        format!(
            " The {name} prism is a pinhole but for a known shift of each row, the same at every depth ({} px RMS): with it undone \
             {} px are left along the rows and {} px across them.",
            px(*raw),
            px(*u),
            px(*v)
        )
    });
    each.collect()
}

fn on_disparity(designs: &[Design]) -> String {
    let judged: Vec<(&str, f64)> =
        designs.iter().filter_map(|d| Some((d.name.as_str(), d.stereo.vertical_disparity_rms_px.measured?))).collect();
    let ready = |rms: f64| match rms {
        r if r < 0.1 => "ready for a stereo matcher without rectification (below 0.1 px)",
        r if r < 0.25 => "usable by a stereo matcher without rectification (below 0.25 px)",
        _ => "too far apart for a stereo matcher without rectification (above 0.25 px)",
    };
    let px = |rms: f64| number(Some(rms));
    let unseen: Vec<&str> =
        designs.iter().map(|d| d.name.as_str()).filter(|name| judged.iter().all(|(n, _)| n != name)).collect();
    let why = |name: &&str| designs.iter().find(|d| d.name == **name)?.not_judged.as_deref();
    let aside: String = unseen
        .iter()
        .map(|name| {
            format!(
                " Of the {name} prism nothing was measured: {}.",
                why(name).unwrap_or("no corner is in both halves")
            )
        })
        .collect();
    let at = match &own_depths(designs)[..] {
        [mm] => format!(", board at {} mm", rounded(*mm)),
        _ => String::new(),
    };
    match judged[..] {
        [(first, a), (second, b)] => format!(
            "The {second} prism leaves {} px of vertical disparity (RMS{at}) where the {first} prism leaves {} px: its raw \
             halves are {}, those of the {first} prism {}.",
            px(b),
            px(a),
            ready(b),
            ready(a)
        ),
        [(name, rms)] => {
            format!(
                "The {name} prism leaves {} px of vertical disparity (RMS{at}): its raw halves are {}.{aside}",
                px(rms),
                ready(rms)
            )
        }
        [] => format!("There is no verdict.{aside}"),
        _ => {
            let mut ranked = judged.clone();
            ranked.sort_by(|a, b| a.1.total_cmp(&b.1));
            let each: Vec<String> = ranked.iter().map(|(name, rms)| format!("{name} {} px", px(*rms))).collect();
            let bands = ranked.chunk_by(|a, b| ready(a.1) == ready(b.1)).map(|band| {
                let names: Vec<&str> = band.iter().map(|(name, _)| *name).collect();
                format!(" {}: {}.", sentence(ready(band[0].1)), names.join(", "))
            });
            let bands: String = bands.collect();
            format!("Vertical disparity of the raw halves (RMS{at}), least first: {}.{bands}{aside}", each.join(", "))
        }
    }
}

/// The words with a capital in front.
fn sentence(words: &str) -> String {
    let mut letters = words.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// The budget of a design in a line.
pub(crate) fn budget_words(name: &str, entry: &ErrorBudget) -> String {
    let any = !entry.corners.is_empty();
    let px = |term: &BudgetTerm| number(any.then_some(term.rms_px));
    let steps = [
        ("optics", Some(&entry.optics)),
        ("fit", entry.fit.as_ref()),
        ("detector", Some(&entry.detector)),
        ("effects", entry.effects.as_ref()),
        ("sampling", Some(&entry.sampling)),
    ];
    let step = |(name, term): (&str, Option<&BudgetTerm>)| Some(format!("{name} {}", px(term?)));
    let sum: Vec<String> = steps.into_iter().filter_map(step).collect();
    format!(
        "steps of a corner's error, RMS px, {name}: {}; in all {} (remainder at most {} px; {} corners left out)",
        sum.join(", "),
        px(&entry.total),
        number(any.then_some(entry.remainder_max_px)),
        entry.left_out,
    )
}
