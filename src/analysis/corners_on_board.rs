//! Corners of a picture by their places on the board: what a detector, ours or another, found in each half, numbered by the
//! board's columns and rows as far as the instrument tells them.

use super::board_indexing::{LatticePlacement, placement};
use super::half_image::HalfFrame;
use super::view::own_side;
use crate::io::corners::{CornerView, IndexOrigin, ListedCorner, Quality};
use crate::raster::Raster;
use crate::system::{InLight, System};
use crate::vision::half::{Half, HalfImage};
use crate::vision::{self, LatticeCorner, Settings, upright};
use glam::DVec2;
use std::collections::BTreeMap;

/// Why corners that were found have no place on the board, as a reason among those of candidates that were turned down.
pub const NOT_INDEXED: &str = "not-indexed";
/// Why a corner of an indexed lattice has none: the board has no corner there.
pub const OFF_BOARD: &str = "off-board";

/// Detects the board of `system` in both halves of `picture` (linear radiance); see [`on_board`].
pub fn detected(system: &System, picture: &Raster<f32>) -> [CornerView; 2] {
    let light = InLight::new(system);
    Half::BOTH.map(|half| {
        // One half after the other: both at once would hold the picture twice.
        let image = HalfImage::cut(picture, half);
        let mask = own_side(system, &HalfFrame::new(system, half));
        let detection = vision::detect(&image.image, mask.as_ref(), &Settings::default());
        on_board(&light, half, CornerView::new(half.name(), image.first_column, &detection))
    })
}

/// The corners of one half, whose indices are then the board's columns and rows, from the inner corner of its top left
/// square on; polarities are those of the board's axes. Corners whose places are not known are left out and counted among
/// those that were turned down: all as [`NOT_INDEXED`] where the instrument does not tell the lattice's place, those beyond the
/// board as [`OFF_BOARD`].
pub fn on_board(light: &InLight<'_>, half: Half, view: CornerView) -> CornerView {
    let view = CornerView { index_origin: Some(IndexOrigin::Board), ..view };
    let frame = HalfFrame::new(light.main(), half);
    // Turn the lattice upright, and keep of each corner how well it was measured, by its position.
    let bits = |px: DVec2| px.to_array().map(f64::to_bits);
    let seen = |c: &ListedCorner| LatticeCorner {
        index: c.index,
        position_px: frame.own(c.position_px),
        polarity: c.quality.map(|q| q.polarity),
        covariance_px2: c.quality.map(|q| q.covariance_px2),
    };
    let lattice = upright(&view.corners.iter().map(seen).collect::<Vec<_>>());
    let listed: BTreeMap<[u64; 2], &ListedCorner> =
        view.corners.iter().map(|c| (bits(frame.own(c.position_px)), c)).collect();

    // Number it by the board.
    let Some(placement) = placement(light, &frame, &lattice) else {
        return without(view.corners.len(), NOT_INDEXED, CornerView { corners: Vec::new(), ..view });
    };
    let inner = light.main().board().inner_corners().map(|n| i32::try_from(n).unwrap_or(i32::MAX));
    let mut corners: Vec<ListedCorner> = lattice
        .iter()
        .filter_map(|c| Some(numbered(&placement, c, listed.get(&bits(c.position_px))?)))
        .filter(|c| (0..inner[0]).contains(&c.index[0]) && (0..inner[1]).contains(&c.index[1]))
        .collect();
    corners.sort_by_key(|c| [c.index[1], c.index[0]]);
    without(view.corners.len() - corners.len(), OFF_BOARD, CornerView { corners, ..view })
}

/// A corner by its place on the board.
fn numbered(placement: &LatticePlacement, corner: &LatticeCorner, listed: &ListedCorner) -> ListedCorner {
    let polarity = corner.polarity.map(|polarity| placement.polarity(polarity));
    let quality = listed.quality.zip(polarity).map(|(quality, polarity)| Quality { polarity, ..quality });
    ListedCorner { index: placement.of(corner.index), position_px: listed.position_px, quality }
}

/// The view with so many corners turned down for one more reason, where there are some.
fn without(corners: usize, reason: &str, mut view: CornerView) -> CornerView {
    if corners > 0 {
        view.rejected.push((reason.to_owned(), corners));
    }
    view
}
