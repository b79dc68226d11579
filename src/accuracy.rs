//! Accuracy levels: the tolerances of a computation. A leaf: plain numbers, each with what it buys.

/// The coarsest target accuracy, in px.
pub(crate) const COARSEST_TARGET_PX: f64 = 1.0;

/// Radiances are kept as f32: a line of the whole contrast cannot be told apart from one this far from it, in px.
pub(crate) const FINEST_TARGET_PX: f64 = 1e-7;

/// Whether a picture of f32 radiances can tell whether it keeps to `target_px`.
pub fn is_told_by_radiance(target_px: f64) -> bool {
    target_px >= FINEST_TARGET_PX
}

/// Whether a picture that is off by `achieved_px` keeps to `target_px`, and can tell.
pub(crate) fn keeps_to(target_px: f64, achieved_px: f64) -> bool {
    is_told_by_radiance(target_px) && achieved_px <= target_px
}

/// A promise about positions in a picture, by name. Each level is cheaper than the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Level {
    /// A coarse map, edges to first order in f32.
    Draft,
    /// A certified map, edges in closed form.
    Standard,
    /// Every pixel traced, edges in closed form.
    Exact,
    /// Slow and simple; judges the others.
    Reference,
}

impl Level {
    /// All levels, cheapest first.
    pub const ALL: [Self; 4] = [Self::Draft, Self::Standard, Self::Exact, Self::Reference];

    /// The name used in scenes and reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Draft => "draft",
            Self::Standard => "standard",
            Self::Exact => "exact",
            Self::Reference => "reference",
        }
    }

    /// The preset of this level.
    pub const fn accuracy(self) -> Accuracy {
        match self {
            Self::Draft => Accuracy::draft(),
            Self::Standard => Accuracy::standard(),
            Self::Exact => Accuracy::exact(),
            Self::Reference => Accuracy::reference(),
        }
    }
}

/// How a picture learns what its pixels see.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Sampling {
    /// A polynomial map that traced rays have certified, traced pixels wherever it is not.
    Map,
    /// Every pixel's centre traced, by packets of rays.
    Packets,
    /// Every pixel's centre traced, ray by ray, and each edge divided until the map is straight in its parts.
    SingleRays,
}

/// Which numbers the pixels of a map are made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Arithmetic {
    /// f32, and coverage to first order, wherever both keep to the bend allowed inside pixels.
    Single,
    /// f64, and coverage in closed form.
    Double,
}

/// The knobs of the simulator. The presets are promises about positions in px; any field may be changed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Accuracy {
    /// The level that these knobs come from.
    pub level: Level,
    /// No edge or corner of the board lies farther than this from where [`Accuracy::reference`] has it, in px.
    pub promise_px: f64,
    /// The target, where the level was chosen by one, in px.
    pub target_px: Option<f64>,
    /// How pixels learn what they see.
    pub sampling: Sampling,
    /// A map is used where it differs from traced rays by less than this, in px.
    pub map_px: f64,
    /// The degree of its polynomials; `None` takes the lowest of 4, 8, 12 and 16 that the rays vouch for.
    pub map_degree: Option<usize>,
    /// Which numbers the pixels of the map are made of. Positions that are traced are f64 in any case.
    pub arithmetic: Arithmetic,
    /// Largest side of one patch of the map, in px.
    pub patch_px: usize,
    /// A freeform surface's intersection is accepted when the ray's distance to it along z is below this, in mm.
    /// 1e-12 mm moves a board point by less than 1e-10 px in the paper's scene.
    pub surface_residual_mm: f64,
    /// A pixel is divided until the map pixel -> board strays from its tangent by less than this inside each part, in px.
    pub bend_px: f64,
    /// Largest number of parts along each side of a pixel.
    pub max_division: u32,
    /// `system::aim` stops when a Newton step is below this, in px.
    pub aim_px: f64,
}

impl Accuracy {
    /// A draft: polynomials of low degree, from few rays, pixels in f32, and divided only where the map bends strongly.
    pub const fn draft() -> Self {
        Self {
            level: Level::Draft,
            promise_px: 1e-2,
            map_px: 1e-3,
            bend_px: 1e-3,
            arithmetic: Arithmetic::Single,
            ..Self::standard()
        }
    }

    /// A certified map. It adds less than 1e-8 px to the errors of [`Accuracy::exact`].
    pub const fn standard() -> Self {
        Self { level: Level::Standard, sampling: Sampling::Map, ..Self::exact() }
    }

    /// Every pixel traced and covered in closed form. What remains is the bend of the map inside a pixel.
    pub const fn exact() -> Self {
        Self {
            level: Level::Exact,
            promise_px: 1e-5,
            target_px: None,
            sampling: Sampling::Packets,
            map_px: 1e-8,
            map_degree: None,
            arithmetic: Arithmetic::Double,
            patch_px: usize::MAX,
            surface_residual_mm: 1e-12,
            bend_px: 5e-6,
            max_division: 32,
            aim_px: 1e-11,
        }
    }

    /// Slow and simple: ray by ray, and every pixel that holds an edge divided until the map is straight in its parts. Judges
    /// the other levels.
    pub const fn reference() -> Self {
        Self {
            level: Level::Reference,
            promise_px: 0.0,
            target_px: None,
            sampling: Sampling::SingleRays,
            map_px: 0.0,
            map_degree: None,
            arithmetic: Arithmetic::Double,
            patch_px: usize::MAX,
            surface_residual_mm: 1e-13,
            bend_px: 1e-7,
            max_division: 1024,
            aim_px: 1e-12,
        }
    }

    /// The cheapest level that promises `target_px`. Between the presets it is [`Accuracy::standard`] with map and bend held to
    /// that; the reference below what an f32 radiance can tell, which is out of
    /// reach: see [`is_told_by_radiance`].
    pub fn for_target(target_px: f64) -> Self {
        let presets = [Self::draft(), Self::standard()];
        let tightened = is_told_by_radiance(target_px).then(|| Self {
            promise_px: target_px,
            map_px: (0.1 * target_px).min(Self::standard().map_px),
            bend_px: 0.5 * target_px,
            max_division: 256,
            ..Self::standard()
        });
        let cheapest = presets.into_iter().find(|a| a.promise_px <= target_px).or(tightened);
        Self { target_px: Some(target_px), ..cheapest.unwrap_or(Self::reference()) }
    }
}
