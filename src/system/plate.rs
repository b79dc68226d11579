//! The plate in place of the checkerboard, where a board has a texture.

use crate::scene::{BoardSpec, TextureSpec};
use crate::texture::noise::noise;
use crate::texture::{Chart, Plate, TexelFilter, Texels, Texture};
use std::sync::Arc;

/// The plate that shows the texture of `spec` on `board`.
pub(super) fn plate(spec: &TextureSpec, board: &BoardSpec) -> Arc<Plate> {
    let texture = match spec {
        TextureSpec::Image(image) => Texture::Picture(Texels::new((*image.light).clone(), image.filter)),
        TextureSpec::Noise { seed, finest_mm } => {
            let [columns, rows] = TextureSpec::noise_texels(board.squares_mm(), *finest_mm).map(|n| n as usize);
            Texture::Picture(Texels::new(noise(columns, rows, *seed), TexelFilter::Linear))
        }
        TextureSpec::Chart => Texture::Chart(Chart::new(board.columns, board.rows)),
    };
    let radiance = [board.black, board.white, board.background];
    Arc::new(Plate::new(texture, 0.5 * spec.size_mm(board.squares_mm()), board.margin_mm, radiance))
}
