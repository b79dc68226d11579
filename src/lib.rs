//! biprism: a virtual stereo camera, one camera that looks through a prism and so takes a stereo pair in one exposure.
//!
//! A pixel's life; each box is one immutable type, each arrow a public function or room:
//!
//! ```text
//! scene.toml --scene::load--> Scene --system::build--> System --render::Plan--> tiles
//!   pixel --System::look--> Result<Sight, Fate> --coverage--> radiance --> Film --raster::{png, exr}--> .png .exr
//!   Raster --vision::half--> two halves --vision::detect--> Corners --metrics--> residuals --report--> .json .csv .png
//! board point --system::aim--> true pixel --------------------------^   (separates detector error from optical error)
//! camera + virtual camera --design--> a prism, as scene text --> in by the front door
//! ```
//!
//! Conventions, kept everywhere: lengths in mm, angles in rad, positions in the image in px; degrees and um only in
//! scene files and reports. Right-handed frame, +z from the camera to the scene, +x right, +y down. The image is
//! un-inverted: +u, +v on the sensor see +x, +y. Pixel (i, j) covers `[i, i+1) x [j, j+1)`; its centre is at
//! (i + 0.5, j + 0.5).

pub mod error;
pub mod accuracy;
pub mod progress;
pub mod num;
pub mod geom;
pub mod optics;
pub mod surface;
pub mod raster;
pub mod io;
pub mod effect;
pub mod scene;
pub mod design;
pub mod prism;
pub mod system;
pub mod render;
pub mod vision;
pub mod metrics;
pub mod analysis;
pub mod golden;
pub mod plot;
pub mod report;
pub mod cli;
