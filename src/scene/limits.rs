//! The limits of a scene file, in one table. Each is in the file's own unit; the schema states them to editors, and
//! the reader to users.
//!
//! They keep every later number finite and every allocation bounded, no more: a scene may be as hard as it likes
//! inside them (a plate, an index ratio of 1, squares far below a pixel, a board at 1e9 mm, one pixel).

/// Bytes of a scene file.
pub(super) const FILE_BYTES: u64 = 4 << 20;
/// Pixels along one side of the sensor.
pub(super) const SIDE_PX: usize = 16384;
/// Objects of one scene.
pub(super) const OBJECTS: usize = 32;
/// The radiance of a black and of a white square where nothing else is said.
pub(super) const BLACK: f64 = 0.05;
pub(super) const WHITE: f64 = 0.85;

/// [`BLACK`], as the default of a key.
pub(super) fn black() -> f64 {
    BLACK
}

/// [`WHITE`], as the default of a key.
pub(super) fn white() -> f64 {
    WHITE
}

/// Squares along one side of the board.
pub(super) const SIDE_SQUARES: usize = 100_000;
/// The shortest focal length, distance, square or scale, in mm: a picometre.
pub(super) const SHORTEST_MM: f64 = 1e-9;
/// The longest length, the largest coordinate and the largest coefficient, in mm: a million kilometres.
pub(super) const LONGEST_MM: f64 = 1e12;
/// The smallest pixel pitch, in um.
pub(super) const SMALLEST_PITCH_UM: f64 = 1e-6;
/// The largest pixel pitch, in um.
pub(super) const LARGEST_PITCH_UM: f64 = 1e6;
/// The farthest principal point from the sensor's corner, along x or y, in px.
pub(super) const PRINCIPAL_PX: f64 = 1e6;
/// The largest coefficient of distortion, either way.
pub(super) const DISTORTION: f64 = 1e9;
/// The largest ratio of the focal lengths along y and x; the smallest is its inverse.
pub(super) const FOCAL_RATIO: f64 = 10.0;
/// The smallest refractive index, of the glass and of what surrounds it.
pub(super) const SMALLEST_INDEX: f64 = 0.1;
/// The largest refractive index.
pub(super) const LARGEST_INDEX: f64 = 10.0;
/// The largest tilt about an axis, either way, in deg.
pub(super) const TILT_DEG: f64 = 360.0;
/// The steepest facet, either way, in deg.
pub(super) const FACET_DEG: f64 = 89.0;
/// The largest radiance, of full scale 1.
pub(super) const RADIANCE: f64 = 1e6;
/// The highest degree of a designed surface.
pub(crate) const DESIGN_DEGREE: usize = 15;
/// The largest weight of a spot against a deviation: above it the law is of no account.
pub(super) const SPOT_WEIGHT: f64 = 1e6;
/// The shortest step of the design, in px.
pub(super) const SHORTEST_STEP_PX: f64 = 1e-3;
/// The longest step of the design, in px.
pub(super) const LONGEST_STEP_PX: f64 = 1e3;
/// Points of the grid that the design marches over one half image.
pub(super) const MARCHED_POINTS: f64 = 1e8;
/// Terms of a polynomial surface: all those of total degree 20.
pub(super) const TERMS: usize = 231;
/// The widest part of a surface of revolution, to each side, in deg.
pub(super) const WIDEST_AZIMUTH_DEG: f64 = 80.0;
/// The smallest angle between the axis of a surface of revolution and z, in deg.
pub(super) const LEAST_AXIS_DEG: f64 = 10.0;
/// Depths of the analysis.
pub(super) const DEPTHS: usize = 16;
/// The fewest points along a side of the analysis grid.
pub(super) const SMALLEST_GRID: usize = 2;
/// The most points along a side of the analysis grid.
pub(super) const LARGEST_GRID: usize = 1025;
/// Claims of one scene.
pub(super) const CLAIMS: usize = 1000;
/// The largest number that a claim may name, either way.
pub(super) const CLAIM: f64 = 1e12;
/// Characters of the name.
pub(super) const NAME_CHARS: usize = 64;
/// Characters of a path, to a file or to a value of the report.
pub(super) const PATH_CHARS: usize = 1024;
/// The smallest f-number: at 0.5 the cone of light in air is a half-space.
pub(super) const SMALLEST_F_NUMBER: f64 = 0.5;
/// The largest f-number.
pub(super) const LARGEST_F_NUMBER: f64 = 1e9;
/// Sides of an aperture.
pub(super) const BLADES: usize = 64;
/// The largest power of a cosine.
pub(super) const EXPONENT: f64 = 100.0;
/// The shortest wavelength, in nm.
pub(super) const SHORTEST_WAVE_NM: f64 = 10.0;
/// The longest wavelength, in nm.
pub(super) const LONGEST_WAVE_NM: f64 = 1e6;
/// The largest seed and the largest number of a frame.
pub(super) const SEED: u32 = u32::MAX;
/// The most electrons that radiance 1 frees, that a pixel holds, or that come in the dark.
pub(super) const ELECTRONS: f64 = 1e9;
/// The largest spread of the pixels' gain, of 1.
pub(super) const UNEVENNESS: f64 = 1.0;
/// Bits of a converter.
pub(super) const ADC_BITS: u32 = 24;
/// The largest black level, in numbers.
pub(super) const BLACK_LEVEL: f64 = (1u32 << ADC_BITS) as f64;
/// The largest gain, in numbers an electron.
pub(super) const GAIN: f64 = 1e9;
/// The largest gamma; the smallest is its inverse.
pub(super) const GAMMA: f64 = 10.0;
/// Points of a pupil.
pub(super) const POINTS: usize = 1 << 16;
/// The thickest layer on a surface, in nm.
pub(super) const THICKEST_LAYER_NM: f64 = 1e5;
/// The largest absorption coefficient, in 1/mm: a mirror coating is a hundred times as dark.
pub(super) const ABSORPTION_PER_MM: f64 = 1e3;
/// Reflections that ghosts are followed through.
pub(super) const BOUNCES: u32 = 16;
/// Rays of ghosts along a side of a pixel.
pub(super) const GHOST_SAMPLES: usize = 16;
/// Wavelengths that stand for the light.
pub(super) const WAVES: usize = 1024;
/// Rows of a sensor's response.
pub(super) const RESPONSE_ROWS: usize = 4096;
/// The largest power of a line, and the largest response.
pub(super) const POWER: f64 = 1e12;
/// The wavelength to which an index belongs where the scene says nothing: the catalogues' n_d, in nm.
pub(super) const D_LINE_NM: f64 = crate::optics::medium::D_NM;
/// Random sets of points.
pub(super) const REPLICATES: usize = 1 << 16;
/// The largest magnification; the smallest is its inverse.
pub(super) const MAGNIFICATION: f64 = 1e6;
/// The largest numerical aperture: the cone of a telecentric lens stays well short of a half-space.
pub(super) const NA: f64 = 0.9;
/// Waves of one surface.
pub(super) const WAVINESS: usize = 1000;
/// The largest root mean square slope of a rough surface, in deg.
pub(super) const ROUGHEST_DEG: f64 = 20.0;
