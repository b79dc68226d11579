//! What the design paper prints, against what is found, and what can be said of each.

use super::convergence::AxisMiss;
use crate::num::ode::Integrator;

/// How close a number that depends on what is not given must be to that of the paper, as a share of it, where its printed digits do
/// not hold more.
const CLOSE: f64 = 0.01;

/// What can be said of a figure or a number of the paper.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ClaimStatus {
    /// Within 1 %, or to the printed digits.
    Reproduced,
    /// The paper contradicts itself or what is known of it.
    SourceInconsistent,
    /// It depends on what the paper does not give.
    NeedsData,
}

impl ClaimStatus {
    /// In words.
    pub const fn words(self) -> &'static str {
        match self {
            Self::Reproduced => "reproduced",
            Self::SourceInconsistent => "not reproduced: source inconsistent",
            Self::NeedsData => "needs data that the paper does not give",
        }
    }
}

/// A number or a figure of the paper.
#[derive(Debug, Clone, PartialEq)]
pub struct PaperClaim {
    /// Which: "Table 1".
    pub item: &'static str,
    /// What of it, with the unit of its numbers.
    pub quantity: String,
    /// As the paper prints it.
    pub printed: &'static str,
    /// The number that is printed, where it is one.
    pub paper: Option<f64>,
    /// The number that is found, where there is one.
    pub here: Option<f64>,
    /// What can be said of it.
    pub status: ClaimStatus,
    /// Why, in a sentence.
    pub why: &'static str,
    /// The command that shows what is found.
    pub command: &'static str,
}

/// What is found of the paper's instrument.
#[derive(Debug, Clone, PartialEq)]
pub struct PaperFindings {
    /// The facet angle, in deg.
    pub facet_angle_deg: f64,
    /// Mean horizontal and vertical error in the virtual image of the flat and of the freeform prism, in mm.
    pub table_1_mm: [[f64; 2]; 2],
    /// Mean distances from O' along the axis, from the longest step to the shortest.
    pub misses: Vec<(Integrator, AxisMiss)>,
    /// Root mean square spot about the centroid of the half image of the flat and of the freeform prism, in um.
    pub spots_um: [f64; 2],
    /// The spot of the freeform prism without errors, by the pupil of those with the errors of Table 2, in um.
    pub table_2_ideal_um: f64,
    /// The spots with these errors.
    pub table_2: Vec<OperandSpot>,
}

/// The spot of a perturbed prism.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OperandSpot {
    /// As Table 2 calls it: "TEDX".
    pub operand: &'static str,
    /// The surface as Table 2 calls it: "1-2".
    pub surface: &'static str,
    /// The larger root mean square spot of both directions, in um.
    pub spot_um: f64,
}

/// Table 2: operand, surface, spot in um.
const TABLE_2: [(&str, &str, &str); 11] = [
    ("TFRN", "1", "5.33"),
    ("TFRN", "2", "4.74"),
    ("TTHI", "1-2", "4.71"),
    ("TEDX", "1-2", "6.26"),
    ("TEDY", "1-2", "4.65"),
    ("TETX", "1-2", "4.60"),
    ("TETY", "1-2", "4.71"),
    ("TETY", "1", "4.60"),
    ("TETX", "1", "4.60"),
    ("TEDX", "2", "7.04"),
    ("TEDY", "2", "4.76"),
];

/// A printed number that is either reproduced or, with the reason, not.
fn number(
    [item, quantity, printed]: [&'static str; 3],
    here: f64,
    close: f64,
    (otherwise, why): (ClaimStatus, &'static str),
    command: &'static str,
) -> PaperClaim {
    let agrees = agrees(printed, here, close);
    PaperClaim {
        item,
        quantity: quantity.to_owned(),
        printed,
        paper: printed.parse().ok(),
        here: Some(here),
        status: if agrees { ClaimStatus::Reproduced } else { otherwise },
        why: if agrees { "" } else { why },
        command,
    }
}

/// Whether `here` rounds to what is printed, or is within the share `close` of it.
fn agrees(printed: &str, here: f64, close: f64) -> bool {
    let Ok(value) = printed.parse::<f64>() else { return false };
    let decimals = printed.split_once('.').map_or(0, |(_, decimals)| decimals.len());
    let half_a_digit = 0.5 * libm::pow(10.0, -(decimals as f64));
    (here - value).abs() <= half_a_digit.max(close * value.abs())
}

/// A figure without numbers that could be compared.
fn drawn(item: &'static str, printed: &'static str, why: &'static str, command: &'static str) -> PaperClaim {
    let quantity = "the figure".to_owned();
    PaperClaim { item, quantity, printed, paper: None, here: None, status: ClaimStatus::NeedsData, why, command }
}

/// Every figure and table of the paper, in its order.
pub fn claims(found: &PaperFindings) -> Vec<PaperClaim> {
    let mut all = vec![
        drawn(
            "Fig. 1",
            "a checkerboard through both prisms",
            "the board's squares and distance are not given",
            "biprism compare scenes/paper.toml",
        ),
        number(
            ["Eq. 5", "facet angle, deg", "8.85"],
            found.facet_angle_deg,
            0.0,
            (ClaimStatus::SourceInconsistent, "the printed formula gives another angle than the printed number"),
            "biprism design scenes/paper.toml",
        ),
        drawn(
            "Fig. 4(a)",
            "the surfaces as points",
            "the distance of the ridge and the thickness of the glass are not given",
            "biprism analyse surface scenes/paper.toml",
        ),
        convergence(found),
        drawn(
            "Fig. 5",
            "error vectors over the half image, flat and freeform",
            "the points and the scale of the arrows are not given; their means are Table 1",
            "biprism analyse reprojection scenes/paper.toml",
        ),
    ];
    all.extend(table_1(found));
    all.push(drawn(
        "Fig. 6",
        "the prism before a bilateral telecentric lens",
        "the prescription of the lens is not given",
        "biprism analyse layout scenes/paper.toml",
    ));
    all.extend(spots(found));
    for (item, printed, command) in [
        ("Fig. 8", "field curvature and distortion", "biprism analyse field-curvature scenes/paper.toml"),
        ("Fig. 9", "contrast over frequency (MTF)", "biprism analyse mtf scenes/paper.toml"),
    ] {
        let why = "the prescription of the lens is not given; here it is an ideal one";
        all.push(drawn(item, printed, why, command));
    }
    all.extend(table_2(found));
    all
}

/// Fig. 4(b): that the distance falls as the step does, which tells the order of the paper's method.
fn convergence(found: &PaperFindings) -> PaperClaim {
    let euler: Vec<f64> =
        found.misses.iter().filter(|(by, _)| *by == Integrator::Euler).map(|(_, miss)| miss.mean_abs_mm).collect();
    let falls = euler.len() > 1 && euler.windows(2).all(|pair| pair[1] < pair[0]);
    PaperClaim {
        item: "Fig. 4(b)",
        quantity: "mean distance from O' with the shortest step, mm".to_owned(),
        printed: "falls to 0 from a step of 91 um to 1 um",
        paper: None,
        here: euler.last().copied(),
        status: if falls { ClaimStatus::Reproduced } else { ClaimStatus::NeedsData },
        why: "falls over the whole range by Euler's method; by the others it ends where the polynomials of degree 5 do",
        command: "biprism analyse convergence scenes/paper.toml",
    }
}

fn table_1(found: &PaperFindings) -> Vec<PaperClaim> {
    let [[flat_h, flat_v], [free_h, free_v]] = found.table_1_mm;
    let undisclosed =
        (ClaimStatus::NeedsData, "its points, the march, the ridge's distance and the thickness are not given");
    let misprint = (ClaimStatus::SourceInconsistent, "the mean of the paper's own two numbers is 0.0770");
    let row = |quantity, printed, here, otherwise| {
        number(["Table 1", quantity, printed], here, CLOSE, otherwise, "biprism analyse reprojection scenes/paper.toml")
    };
    vec![
        row("flat, horizontal, mm", "0.0604", flat_h, undisclosed),
        row("flat, vertical, mm", "0.0936", flat_v, undisclosed),
        row("flat, average, mm", "0.0670", 0.5 * (flat_h + flat_v), misprint),
        row("freeform, horizontal, mm", "0.0154", free_h, undisclosed),
        row("freeform, vertical, mm", "0.0011", free_v, undisclosed),
        row("freeform, average, mm", "0.00825", 0.5 * (free_h + free_v), undisclosed),
    ]
}

fn spots(found: &PaperFindings) -> Vec<PaperClaim> {
    let [flat, freeform] = found.spots_um;
    let command = "biprism analyse spot scenes/paper.toml";
    let undisclosed = (ClaimStatus::NeedsData, "the prescription of the lens is not given");
    let contradicted = (
        ClaimStatus::SourceInconsistent,
        "Table 2 has 4.60 of the same prism, and 6.26 of one that is decentred; the lens is not given",
    );
    vec![
        number(["Fig. 7(a)", "flat, RMS spot, um", "64.004"], flat, CLOSE, undisclosed, command),
        number(["Fig. 7(b)", "freeform, RMS spot, um", "6.259"], freeform, CLOSE, contradicted, command),
    ]
}

/// Table 2, none of whose rows is said to be reproduced: its ideal spot contradicts Fig. 7.
fn table_2(found: &PaperFindings) -> Vec<PaperClaim> {
    let row = |quantity: String, printed: &'static str, here: Option<f64>| PaperClaim {
        item: "Table 2",
        quantity,
        printed,
        paper: printed.parse().ok(),
        here,
        status: ClaimStatus::SourceInconsistent,
        why: "its ideal spot of 4.60 um contradicts the 6.259 um of Fig. 7(b), and the lens is not given",
        command: "biprism analyse tolerance scenes/paper.toml",
    };
    let ideal = row("no deviation, spot, um".to_owned(), "4.60", Some(found.table_2_ideal_um));
    let operands = TABLE_2.into_iter().map(|(operand, surface, printed)| {
        let own = found.table_2.iter().find(|spot| spot.operand == operand && spot.surface == surface);
        row(format!("{operand} {surface}, spot, um"), printed, own.map(|spot| spot.spot_um))
    });
    std::iter::once(ideal).chain(operands).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn printed_digits_or_a_hundredth_are_asked() {
        let close = |printed, here| agrees(printed, here, CLOSE);
        assert!(close("8.85", 8.8549) && close("64.004", 63.4) && close("0.0011", 0.001_145));
        assert!(!close("8.85", 8.95) && !close("64.004", 63.3) && !close("0.0011", 0.001_16));
        // The angle that the printed Eq. 5 gives is not the printed one.
        assert!(agrees("8.85", 8.8549, 0.0) && !agrees("8.85", 8.91, 0.0));
    }

    #[test]
    fn a_status_follows_what_is_found() {
        let miss = |mean_abs_mm| AxisMiss { degree: 5, mean_abs_mm, path_spread_mm: 0.0 };
        let found = PaperFindings {
            facet_angle_deg: 8.91,
            table_1_mm: [[0.0604, 0.0936], [0.0154, 0.0009]],
            misses: vec![(Integrator::Euler, miss(0.1)), (Integrator::Rk4, miss(0.3)), (Integrator::Euler, miss(0.2))],
            spots_um: [60.0, 0.49],
            table_2_ideal_um: 0.44,
            table_2: vec![OperandSpot { operand: "TEDX", surface: "2", spot_um: 7.04 }],
        };
        let all = claims(&found);
        let status = |item: &str, quantity: &str| {
            all.iter().find(|claim| claim.item == item && claim.quantity.starts_with(quantity)).expect(item).status
        };
        assert_eq!(status("Eq. 5", ""), ClaimStatus::SourceInconsistent);
        assert_eq!(status("Table 1", "flat, horizontal"), ClaimStatus::Reproduced);
        assert_eq!(status("Table 1", "flat, average"), ClaimStatus::SourceInconsistent);
        assert_eq!(status("Table 1", "freeform, vertical"), ClaimStatus::NeedsData);
        assert_eq!(status("Fig. 4(b)", ""), ClaimStatus::NeedsData);
        assert_eq!(status("Fig. 7(a)", ""), ClaimStatus::NeedsData);
        // A table that contradicts itself is not reproduced by a row that happens to agree.
        assert_eq!(status("Table 2", "TEDX 2"), ClaimStatus::SourceInconsistent);
    }
}
