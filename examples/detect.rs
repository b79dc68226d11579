//! The corner detector by itself: `cargo run --release --example detect [PICTURE] [srgb|linear]`.
//!
//! A picture in, corners with their covariance out, and into a file for OpenCV.
//!
//! ```sh
//! cargo run --release --example detect                          # a board made here
//! cargo run --release --example detect -- photo.jpg srgb        # any picture: PNG, EXR, JPEG, BMP or PNM
//! ```
//!
//! The second argument, `srgb` or `linear`, states the curve of a picture that does not say its own; none is guessed.
//! Corners go to `corners.yml`, which `cv::FileStorage` reads; the endings `.csv` and `.json` work as well.

use biprism::io::atomic;
use biprism::io::corners::{CornerFormat, CornerView, to_text};
use biprism::raster::Raster;
use biprism::raster::transfer::Transfer;
use biprism::vision::Settings;
use biprism::{Error, detect};
use std::path::Path;

/// A board of 40 px squares whose lines lie between pixels: a pixel that a line cuts holds the mean of both its sides.
fn board() -> Raster<f32> {
    let line = |pixel: usize| {
        // Squares begin at 13.3 + 40 k; the share of the pixel that lies in squares of odd number.
        let (low, high) = (pixel as f64 - 13.3, pixel as f64 - 12.3);
        let odd_up_to = |x: f64| 40.0 * (x / 80.0).floor() + (x.rem_euclid(80.0) - 40.0).max(0.0);
        odd_up_to(high) - odd_up_to(low)
    };
    let value = |k: usize| {
        let (u, v) = (line(k % 320), line(k / 320));
        (0.05 + 0.8 * (u * v + (1.0 - u) * (1.0 - v))) as f32
    };
    Raster::from_data(320, 240, (0..320 * 240).map(value).collect())
}

fn picture() -> Result<Raster<f32>, Error> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let stated = match arguments.get(1).map(String::as_str) {
        Some("srgb") => Some(Transfer::Srgb),
        Some("linear") => Some(Transfer::Linear),
        _ => None,
    };
    match arguments.first() {
        Some(path) => biprism::io::read(Path::new(path), stated).map(|(picture, _)| picture),
        None => Ok(board()),
    }
}

fn run() -> Result<(), Error> {
    let picture = picture()?;
    // All pixels count; a mask would leave out those where it is false.
    let found = detect(&picture, None, &Settings::default());
    println!("{} corners, blur across columns and rows {:?} px", found.corners.len(), found.sigma_px);
    for corner in found.corners.iter().take(5) {
        let p = corner.position_px;
        let sigma = [corner.covariance_px2.x_axis.x, corner.covariance_px2.y_axis.y].map(f64::sqrt);
        println!("{:?} at ({:.5}, {:.5}) px, +- ({:.5}, {:.5}) px", corner.index, p.x, p.y, sigma[0], sigma[1]);
    }
    for (reason, count) in found.counts().into_iter().filter(|(_, count)| *count > 0) {
        println!("{count} candidates turned down: {}", reason.name());
    }
    // Positions are in px with pixel (i, j) centred at (i + 0.5, j + 0.5); the file for OpenCV has them 0.5 less.
    let text = to_text(&[CornerView::new("whole", 0, &found)], CornerFormat::OpenCv);
    atomic::write_bytes(Path::new("corners.yml"), text.as_bytes())
}

fn main() {
    if let Err(error) = run() {
        eprintln!("{error}");
        std::process::exit(2);
    }
}
