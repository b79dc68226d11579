//! The design paper's figures and tables beside what is found: a sheet, and one page with the figures in it.

use super::document::StudyFigure;
use crate::analysis::paper_claims::PaperClaim;
use crate::geom::Rect;
use crate::plot::colour::INK;
use crate::plot::drawing::{Drawing, Item};
use crate::plot::picture;
use crate::plot::text::{Align, Font};
use crate::raster::Raster;
use crate::report::page::origin::PageOrigin;
use crate::report::page::study::StudyPage;
use crate::report::sheet::StudySheet;
use glam::DVec2;

/// Pixels of a picture that are drawn as one, along each side.
const BIN: usize = 4;
/// Room above a picture for its name, in px.
const NAME_PX: f64 = 34.0;

/// The figures of an item of the paper.
#[derive(Debug, Clone)]
pub struct ItemFigures {
    /// The item: "Fig. 7(a)"; several items in one part of the page stand under the first.
    pub item: &'static str,
    /// Its figures.
    pub figures: Vec<StudyFigure>,
}

/// What the paper says, what is found, and what can be said of it.
pub fn sheet(claims: &[PaperClaim]) -> StudySheet {
    let mut sheet = StudySheet::new(
        "paper",
        "The design paper's figures and tables",
        &[
            ("item", "the figure or table"),
            ("quantity", "what of it, with the unit of its numbers"),
            ("printed", "as the paper has it"),
            ("here", "the number that is found"),
            ("off_percent", "how far that is from the printed one, % of it"),
            ("status", "reproduced: within 1 % or to the printed digits; or why not"),
            ("why", "the reason"),
            ("command", "the command that shows what is found"),
        ],
    );
    for claim in claims {
        sheet.push(vec![
            claim.item.into(),
            claim.quantity.as_str().into(),
            claim.printed.into(),
            claim.here.into(),
            off_percent(claim).into(),
            claim.status.words().into(),
            claim.why.into(),
            claim.command.into(),
        ]);
    }
    sheet
}

fn off_percent(claim: &PaperClaim) -> Option<f64> {
    claim.paper.zip(claim.here).map(|(paper, here)| 100.0 * (here / paper - 1.0))
}

/// The pictures that the prisms make, one above the other, for Fig. 1.
pub fn pictures(named: &[(String, Raster<f32>)]) -> StudyFigure {
    let title = "A checkerboard through the prisms".to_owned();
    let reduced: Vec<(&str, Raster<f32>)> = named.iter().map(|(name, p)| (name.as_str(), binned(p))).collect();
    let width = reduced.iter().map(|(_, p)| p.width()).max().unwrap_or(0);
    let height: usize = reduced.iter().map(|(_, p)| p.height() + NAME_PX as usize).sum();
    let mut drawing = Drawing::new(width as u32, height as u32);
    let mut top = 0.0;
    for (name, picture) in &reduced {
        let at = DVec2::new(8.0, top + 0.7 * NAME_PX);
        drawing.text(format!("{name} prism"), Font::bold(18.0), INK, at, Align::Start);
        let min = DVec2::new(0.0, top + NAME_PX);
        let max = min + DVec2::new(picture.width() as f64, picture.height() as f64);
        drawing.push(Item::Picture(Rect { min, max }, picture::grey(picture)));
        top = max.y;
    }
    StudyFigure { name: "checkerboard".to_owned(), title, drawing }
}

/// The means over squares of [`BIN`] x [`BIN`] pixels.
fn binned(picture: &Raster<f32>) -> Raster<f32> {
    let (width, height) = (picture.width() / BIN, picture.height() / BIN);
    let mean = |i: usize, j: usize| {
        let rows = (0..BIN).flat_map(|row| &picture.row(BIN * j + row)[BIN * i..BIN * (i + 1)]);
        rows.sum::<f32>() / (BIN * BIN) as f32
    };
    Raster::from_data(width, height, (0..width * height).map(|k| mean(k % width, k / width)).collect())
}

/// What stands before the table.
const INTRODUCTION: &str = "What \"freeform prism for single-lens stereovision\" prints, what biprism finds, and what can be \
    said of it. Reproduced is what agrees within 1 % or to the printed digits. The paper does not give the distance of the ridge \
    and the thickness of the glass: both are chosen so that the flat row of Table 1 comes out. Nor does it give its lens: here it \
    is an ideal telecentric one, behind which a point at the camera's pinhole is seen backwards through one half of the prism.";

/// The page by itself: HTML with its figures in it.
pub fn html(claims: &[PaperClaim], figures: &[ItemFigures], origin: &PageOrigin) -> String {
    let page = StudyPage {
        title: "The design paper, figure by figure",
        introduction: INTRODUCTION,
        sheets: &[sheet(claims)],
        figures: figures.iter().map(|part| (part.item, part.figures.iter().collect())).collect(),
    };
    page.html(origin)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn squares_of_pixels_have_their_means() {
        let picture = Raster::from_data(8, 4, (0..32).map(|k| k as f32).collect());
        // Of the columns 0..4 and 4..8 over the four rows that begin at 0, 8, 16, 24.
        assert_eq!(binned(&picture).data(), [13.5, 17.5]);
    }

    #[test]
    fn a_page_holds_its_claims_and_its_figures() {
        let claim = PaperClaim {
            item: "Table 1",
            quantity: "flat <b>, mm".to_owned(),
            printed: "0.0670",
            paper: Some(0.0670),
            here: Some(0.0770),
            status: crate::analysis::paper_claims::ClaimStatus::SourceInconsistent,
            why: "a & b",
            command: "biprism",
        };
        let picture = pictures(&[("flat".to_owned(), Raster::filled(8, 8, 0.5))]);
        let origin = PageOrigin::new(&["biprism".to_owned()], Vec::new());
        let page = html(&[claim], &[ItemFigures { item: "Fig. 1", figures: vec![picture] }], &origin);
        assert!(page.contains("flat &lt;b&gt;, mm") && page.contains("14.925") && page.contains("a &amp; b"));
        assert!(page.contains("not reproduced: source inconsistent") && page.matches("<svg").count() == 1);
        // Nothing is fetched from elsewhere.
        assert!(!page.contains("src=\"http") && !page.contains("href=\"http"));
    }
}
