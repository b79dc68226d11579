//! A virtual stereo camera: one camera that looks through a prism and so takes a stereo pair in one exposure.
//!
//! biprism designs such a prism, renders what the camera sees through it, finds the corners of a checkerboard in the
//! picture, and says how far the pair is from two ideal pinhole cameras.
//!
//! # What it does
//! - **Designs** the freeform biprism of "freeform prism for single-lens stereovision" from a camera and a flat prism
//!   ([`fn@design`]), and takes prisms as polynomials, point clouds and triangle meshes as well ([`scene`]).
//! - **Renders** a checkerboard through it ([`fn@render`]): each pixel the exact area mean of the board under it, with what
//!   its centre sees, the promise of its accuracy in px and what was found of it ([`Film`], [`accuracy`]).
//! - Adds, only where a scene asks for it, a lens of finite aperture, dispersion, Fresnel loss, ghosts, errors of
//!   manufacture, diffraction, a real sensor and others ([`effect`]).
//! - **Detects** corners in any picture, with their covariance ([`detect`]); the detector knows nothing of the simulator.
//! - **Measures** vertical disparity, epipolar lines and the deviation from a pinhole ([`measure`], [`metrics`]), from the
//!   corners found and from exact ones ([`system::aim`]), and **compares** a flat with a freeform prism ([`compare`]).
//!
//! # What it does not do
//! - The only object is one flat checkerboard; there is no other scene, and light reaches it as a scene says, unshadowed.
//! - A board has no mark of its own: where a picture shows a part of it, which part it is, and which corner of one half is which
//!   of the other, is told by camera, prism and board of the scene, and the report says so.
//! - Prisms are compared by one board pose at several depths, not by a full calibration.
//! - The library is not on a registry and has no stable version: names may change from one commit to the next, and
//!   `CHANGELOG.md` says so.
//!
//! # Conventions
//! Lengths in mm, angles in rad, wavelengths in nm, positions in the image in px; degrees and um only in scene files and
//! reports. Names carry the unit (`pitch_mm`). Right-handed frame, +z from the camera to the scene, +x right, +y down. The
//! image is un-inverted: +u, +v on the sensor see +x, +y. Pixel (i, j) covers `[i, i+1) x [j, j+1)`; its centre is at
//! (i + 0.5, j + 0.5). Points and directions are [`glam`]'s `DVec2` and `DVec3`. Results are the same, bit for bit, on every
//! run and for any number of threads.
//!
//! A ray that ends is data ([`optics::fate::Fate`]), never a NaN; a user's mistake is an [`Error`] with place, rule and next
//! step.
//!
//! # Examples
//! Render a picture, and write it with its truth, what every pixel sees through the prism, as EXR:
//! ```
//! let scene = biprism::scene::load("scenes/cases/prism_flat.toml".as_ref())?;
//! let system = biprism::system::build(&scene)?;
//! let film = biprism::render(&system, &());
//! assert!(film.account.achieved_px() < film.account.promise_px);
//! let path = std::env::temp_dir().join("biprism.exr");
//! biprism::report::picture::write(&path, &scene, &system, &film)?;
//! # Ok::<(), biprism::Error>(())
//! ```
//!
//! Judge a flat prism against the freeform prism designed from it:
//! ```
//! let scene = biprism::scene::load("scenes/cases/prism_freeform.toml".as_ref())?;
//! let comparison = biprism::compare(&scene, &())?;
//! for design in &comparison.designs {
//!     let vertical = design.judgement.vertical_disparity_rms_px();
//!     println!("{}: {:?} px measured, {:?} px true", design.name, vertical.measured, vertical.exact);
//! }
//! # Ok::<(), biprism::Error>(())
//! ```
//!
//! The detector alone, here on a picture made by hand:
//! ```
//! use biprism::{detect, raster::Raster, vision::Settings};
//!
//! let board = |k: usize| if (k % 200 / 30 + k / 200 / 30) % 2 == 0 { 0.8 } else { 0.1 };
//! let picture = Raster::from_data(200, 160, (0..200 * 160).map(board).collect());
//! for corner in detect(&picture, None, &Settings::default()).corners {
//!     println!("{:?} at {} px, covariance {}", corner.index, corner.position_px, corner.covariance_px2);
//! }
//! ```
//!
//! Design a prism, as the text of a scene:
//! ```
//! use biprism::{design::{DesignInput, VIRTUAL_CAMERA_Z_MM, text}, scene::{DesignSettings, PrismSpec}};
//!
//! let scene = biprism::scene::load("scenes/paper.toml".as_ref())?;
//! let PrismSpec::Freeform(prism, _) = scene.prism else { panic!("the paper's prism is freeform") };
//! let settings = DesignSettings { step_px: 40.0, ..DesignSettings::default() };
//! let input = DesignInput { camera: scene.camera, prism, settings, virtual_camera_z_mm: VIRTUAL_CAMERA_Z_MM };
//! let designed = biprism::design(&input)?;
//! println!("{}", text::scene_prism(&designed.front.patch, &designed.back.patch, &prism.body));
//! # Ok::<(), biprism::Error>(())
//! ```
//!
//! # A pixel's life
//! Data moves one way; each box is an immutable type, each arrow a public function or room.
//!
//! ```text
//! scene.toml --scene::load--> Scene --system::build (designs if asked)--> System --render--> Film --io--> .png .exr
//!   Raster --vision::half--> two halves --detect--> Corners --metrics--> residuals --report--> .json .csv .png
//! board point --system::aim--> true pixel -----------------^   (separates detector error from optical error)
//! camera + virtual camera --design--> a prism, as scene text --> in by the front door
//! ```
//!
//! The modules below are the rooms of the code in reading order; `docs/architecture.md` has the rule of each, and how to
//! add an effect, a surface, a format or a metric.

pub mod error;
pub mod accuracy;
pub mod progress;
pub mod num;
pub mod geom;
pub mod optics;
pub mod surface;
pub mod raster;
pub mod texture;
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

pub use analysis::compare::{compare, compare_scenes};
pub use analysis::judge::measure;
pub use design::freeform as design;
pub use error::Error;
pub use glam;
pub use render::{Film, render};
pub use scene::Scene;
pub use system::System;
pub use vision::detect;
