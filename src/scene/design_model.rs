//! How a freeform prism is designed, as checked values.

/// How a freeform prism is designed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DesignSettings {
    /// What the surfaces are to be.
    pub objective: Objective,
    /// What a design becomes.
    pub surface: DesignedSurface,
    /// z of the virtual cameras' centres O' in the prism's frame, in mm; `None` by the objective.
    pub virtual_camera_z_mm: Option<f64>,
    /// Which way the grid is marched.
    pub order: MarchOrder,
    /// Total degree p of the fitted polynomial (Eq. 6), with even powers of y only.
    pub degree: usize,
    /// The integrator.
    pub method: Method,
    /// Step, in px of the sensor: see [`DesignSettings::step_for`].
    pub step_px: f64,
    /// What else is asked of the surfaces.
    pub goal: DesignGoal,
}

/// What is asked of a designed prism besides its objective.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DesignGoal {
    /// The surface that faces the board.
    pub rear: Rear,
    /// Whether a pinhole has square pixels of the camera's own focal length.
    pub square: bool,
    /// The aperture of the lens whose spots are counted, as f/N.
    pub f_number: Option<f64>,
    /// How much a spot of the lens counts against a deviation from the law of the same size; 0: not at all.
    pub spot_weight: f64,
    /// The nearest depth at which the law is to hold, from the camera along z, in mm; the farthest is infinity.
    pub z_min_mm: f64,
    /// The depth of [`Objective::Depth`], and where the lens is focused, in mm.
    pub depth_mm: f64,
}

impl DesignGoal {
    /// Own rear surfaces, no lens, from 0.3 m on, and 1 m.
    pub const PLAIN: Self =
        Self { rear: Rear::Own, square: false, f_number: None, spot_weight: 0.0, z_min_mm: 300.0, depth_mm: 1000.0 };
}

impl Default for DesignGoal {
    /// [`DesignGoal::PLAIN`].
    fn default() -> Self {
        Self::PLAIN
    }
}

/// The surface of a designed prism that faces the board.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rear {
    /// A freeform of its own for each half.
    Own,
    /// One freeform for both halves, even in x and smooth across x = 0.
    Even,
    /// The plane base of the flat prism.
    Flat,
}

/// Steps across a half image where nothing else is said: they divide the 960 px of the design paper's at 16 px.
const STEPS_ACROSS: f64 = 60.0;

impl DesignSettings {
    /// The design paper's for a sensor of `width_px` columns, in the steps of [`DesignSettings::step_for`].
    pub fn of_sensor(width_px: usize) -> Self {
        Self { step_px: Self::step_for(width_px), ..Self::default() }
    }

    /// The step where nothing else is said, in px: a sixtieth of the half image's width, and no less than a pixel. The march is of
    /// the fourth order and the fit weights its points by Simpson's rule, so that 60 steps across are as good as one a pixel.
    pub fn step_for(width_px: usize) -> f64 {
        (width_px as f64 / (2.0 * STEPS_ACROSS)).max(1.0)
    }

    /// Whether the surfaces are found by least squares, and not by integration.
    pub fn by_least_squares(&self) -> bool {
        match self.objective {
            Objective::March => false,
            Objective::Epipolar | Objective::ToedIn => self.goal.rear != Rear::Own || self.goal.spot_weight > 0.0,
            Objective::Pinhole | Objective::Depth => true,
        }
    }
}

impl Default for DesignSettings {
    /// The design paper's: x then y, p = 5, RK4; for its sensor in steps of 16 px.
    fn default() -> Self {
        Self {
            objective: Objective::March,
            surface: DesignedSurface::Polynomial,
            virtual_camera_z_mm: None,
            order: MarchOrder::XThenY,
            degree: 5,
            method: Method::Rk4,
            step_px: 16.0,
            goal: DesignGoal::default(),
        }
    }
}

/// What the surfaces of a freeform prism are to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Objective {
    /// The design paper's: marched so that each half is nearly a pinhole parallel to the camera.
    March,
    /// Exactly horizontal epipolar lines: surfaces of revolution about the baseline.
    Epipolar,
    /// Exact pinholes whose axes are turned outwards: surfaces of revolution about the line from the camera's pinhole to the
    /// virtual camera's.
    ToedIn,
    /// A pinhole parallel to the camera.
    Pinhole,
    /// A pinhole parallel to the camera, of a board at one depth.
    Depth,
}

impl Objective {
    /// Whether its prisms are traced as one piece of glass where nothing else is said: the paper's march keeps its two
    /// idealised surfaces.
    pub fn is_solid(self) -> bool {
        self != Self::March
    }
}

/// What the surfaces of a design are made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DesignedSurface {
    /// Polynomials that are fitted to them.
    Polynomial,
    /// Themselves: surfaces of revolution, of the objectives that have them.
    Revolved,
}

/// The order of the two marches of the design.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MarchOrder {
    /// The centre row along x, then every column along y.
    XThenY,
    /// The centre column along y, then every row along x.
    YThenX,
}

/// An integrator of ordinary differential equations.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// First order.
    Euler,
    /// Second order.
    Midpoint,
    /// The classical Runge-Kutta method of fourth order.
    Rk4,
}
