//! Effects beyond geometrical optics: one opt-in effect a file, and one table of them all.
//!
//! An effect exists for a scene when the scene has its table `[effect.<name>]`; one of strength 0 is as good as absent,
//! bit for bit. There are four kinds, by the place where they take hold ([`Hook`]):
//!
//! - **Instrument** effects are built into the instrument: `system` knows them, and so do its rays and fates.
//! - **Ray** effects average pictures. A finite pupil shows the mean of what its points see, each of which is a pinhole:
//!   [`Effects::variants`] lists the variants of the instrument with their weights, `System::variant` builds one of them,
//!   and `render` sums up their pictures, each by the certified map and without noise.
//! - **Transport** effects weaken light on its way by a smooth factor: [`Effects::throughput`] multiplies the factors of one
//!   ray, given its [`LightPath`]; `render` evaluates it at every pixel, or at every piece of a pixel that a border cuts.
//! - **Film** effects act on the whole picture after all passes: diffraction where `render` spreads the light and adds what
//!   the cells of unevenly lit pixels make, then the sensor by [`Effects::develop`]. They may need the light over a part of
//!   each pixel ([`Effects::active_side`]).
//!
//! A scene without effects is rendered by loops that know of none.
//!
//! # How to add an effect
//!
//! 1. `effect/<name>.rs`: the settings as a plain struct of validated values in mm, rad and nm (field names carry the
//!    unit), its formulas as functions of numbers with their source, `is_nothing()` for strength 0, and tests of them
//!    against closed forms. This room uses `num`, `geom`, `optics` and `raster` at most.
//! 2. Here: a field of [`Effects`], a variant of [`EffectId`], a row of [`TABLE`] (in `effect/table.rs`), and one line in `at`, `throughput`
//!    or `develop`, or in `System::with_effects` for the instrument. A ray effect adds what it varies to [`Variant`] and
//!    the change itself to `System::variant` in `system/variants.rs`; a transport effect finds all it may need in [`LightPath`].
//! 3. `scene/effects/`: the table of the scene file with its ranges, its line in `EffectTables` and its conversion; what it and
//!    the rest of the scene say of each other in `rules.rs`, and its settings in `ranges.rs`, for scenes made in code; then the
//!    schema is written anew (`UPDATE_SCHEMA=1`, see `tests/scene_schema.rs`).
//! 4. `scenes/cases/effect_<name>.toml` with its golden, and in `tests/effects.rs` what theory says of the picture. The
//!    tests there that walk [`TABLE`] find a case that is missing, an effect that does nothing, and one whose zero is
//!    not nothing.

pub mod absorption;
pub mod clipping;
pub mod coating;
pub mod cos4;
pub mod diffraction;
pub mod dispersion;
pub mod fresnel;
pub mod ghosts;
pub mod journey;
pub mod lamp;
pub mod manufacture;
pub mod quadrature;
pub mod roughness;
pub mod sensor;
mod hook;
mod id;
mod lens;
pub mod pupil;
mod table;
pub mod telecentric;
pub mod thin_lens;
mod effects;
mod variant;
mod picture;

pub use effects::{Effects, Threshold};
pub use picture::{Picture, merged};
pub use variant::{Variant, Variants};

pub use absorption::Absorption;
pub use clipping::Clipping;
pub use coating::Coating;
pub use cos4::Cos4;
pub use diffraction::Diffraction;
pub use dispersion::Dispersion;
pub use fresnel::Fresnel;
pub use ghosts::Ghosts;
pub use hook::Hook;
pub use id::EffectId;
pub use journey::{BoardPoint, LightPath};
pub use lamp::Lamp;
pub use lens::Lens;
pub use manufacture::Manufacture;
pub use quadrature::{Points, Quadrature};
pub use roughness::Roughness;
pub use sensor::Sensor;
pub use table::{Bounding, EffectRow, TABLE};
pub use telecentric::Telecentric;
pub use thin_lens::ThinLens;
