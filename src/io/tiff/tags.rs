//! The tags of a TIFF that are asked for (revision 6.0, appendix A).

/// A tag's number, which its name stands for in messages.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Tag(pub(super) u16, &'static str);

impl std::fmt::Display for Tag {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.1)
    }
}

pub(super) const SUBFILE_TYPE: Tag = Tag(254, "NewSubfileType");
pub(super) const WIDTH: Tag = Tag(256, "ImageWidth");
pub(super) const HEIGHT: Tag = Tag(257, "ImageLength");
pub(super) const BITS: Tag = Tag(258, "BitsPerSample");
pub(super) const COMPRESSION: Tag = Tag(259, "Compression");
pub(super) const PHOTOMETRIC: Tag = Tag(262, "PhotometricInterpretation");
pub(super) const FILL_ORDER: Tag = Tag(266, "FillOrder");
pub(super) const STRIP_OFFSETS: Tag = Tag(273, "StripOffsets");
pub(super) const ORIENTATION: Tag = Tag(274, "Orientation");
pub(super) const SAMPLES: Tag = Tag(277, "SamplesPerPixel");
pub(super) const STRIP_ROWS: Tag = Tag(278, "RowsPerStrip");
pub(super) const STRIP_BYTES: Tag = Tag(279, "StripByteCounts");
pub(super) const PLANAR: Tag = Tag(284, "PlanarConfiguration");
pub(super) const PREDICTOR: Tag = Tag(317, "Predictor");
pub(super) const TILE_WIDTH: Tag = Tag(322, "TileWidth");
pub(super) const TILE_HEIGHT: Tag = Tag(323, "TileLength");
pub(super) const TILE_OFFSETS: Tag = Tag(324, "TileOffsets");
pub(super) const TILE_BYTES: Tag = Tag(325, "TileByteCounts");
pub(super) const SAMPLE_FORMAT: Tag = Tag(339, "SampleFormat");
