//! Operands: the errors that a prism may have, and how each is put into a scene.

use super::misshapen::{steeper, turned_patch, turned_triangles, with_radius};
use crate::effect::Manufacture;
use crate::effect::manufacture::Displacement;
use crate::error::Error;
use crate::scene::{PrismSpec, Scene};
use glam::DVec3;

/// An error of the prism. Surface 1 is the front with its ridge, surface 2 the back.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Operand {
    /// The front's radius of curvature (the mean one at the middle of the half) is larger: a paraboloid is added about that place.
    Radius1,
    /// The same of the back.
    Radius2,
    /// The back lies farther from the front.
    Thickness,
    /// The whole prism is shifted along x.
    DecentreX,
    /// The whole prism is shifted along y.
    DecentreY,
    /// Both surfaces turn about x, each about its own middle.
    TiltX,
    /// Both surfaces turn about y, each about its own middle.
    TiltY,
    /// The front turns about y.
    TiltY1,
    /// The front turns about x.
    TiltX1,
    /// The back is shifted along x.
    DecentreX2,
    /// The back is shifted along y.
    DecentreY2,
    /// The glass has a larger index.
    Index,
    /// Both facets are steeper, turned about the ridge.
    FacetAngle,
    /// The front with its ridge is shifted along x.
    Ridge,
    /// The whole prism is rolled about z.
    Roll,
    /// The back is rolled about z.
    Roll2,
}

impl Operand {
    /// All, those of the design paper's Table 2 in its order first.
    pub const ALL: [Self; 16] = [
        Self::Radius1,
        Self::Radius2,
        Self::Thickness,
        Self::DecentreX,
        Self::DecentreY,
        Self::TiltX,
        Self::TiltY,
        Self::TiltY1,
        Self::TiltX1,
        Self::DecentreX2,
        Self::DecentreY2,
        Self::Index,
        Self::FacetAngle,
        Self::Ridge,
        Self::Roll,
        Self::Roll2,
    ];

    /// Those of the design paper's Table 2, in its order.
    pub const TABLE_2: &[Self] = Self::ALL.split_at(11).0;

    /// Its name: the paper's, and ours for what the paper does not have.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Radius1 => "TFRN 1",
            Self::Radius2 => "TFRN 2",
            Self::Thickness => "TTHI 1-2",
            Self::DecentreX => "TEDX 1-2",
            Self::DecentreY => "TEDY 1-2",
            Self::TiltX => "TETX 1-2",
            Self::TiltY => "TETY 1-2",
            Self::TiltY1 => "TETY 1",
            Self::TiltX1 => "TETX 1",
            Self::DecentreX2 => "TEDX 2",
            Self::DecentreY2 => "TEDY 2",
            Self::Index => "index",
            Self::FacetAngle => "facet angle",
            Self::Ridge => "ridge offset",
            Self::Roll => "prism roll",
            Self::Roll2 => "roll 2",
        }
    }

    /// The operand of this name, whatever its letters' case.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|operand| operand.name().eq_ignore_ascii_case(name))
    }

    /// The unit of its amount.
    pub const fn unit(self) -> &'static str {
        match self {
            Self::TiltX | Self::TiltY | Self::TiltX1 | Self::TiltY1 | Self::FacetAngle | Self::Roll | Self::Roll2 => {
                "deg"
            }
            Self::Index => "1",
            _ => "mm",
        }
    }

    /// The amount that is tried where none is given: the paper's in its Table 2, and of what it does not have, what a workshop keeps to
    /// without effort: an index of 1e-3, a minute of arc, 0.2 mm.
    pub const fn usual(self) -> f64 {
        match self {
            Self::Radius1 | Self::Radius2 => 1.0,
            Self::Index => 1e-3,
            Self::FacetAngle | Self::Roll | Self::Roll2 => 1.0 / 60.0,
            _ => 0.2,
        }
    }

    /// Whether a prism of this kind can have the error: radii only where surfaces are polynomials.
    pub fn acts_on(self, prism: &PrismSpec) -> bool {
        match self {
            Self::Radius1 | Self::Radius2 => matches!(prism, PrismSpec::Polynomial(_)),
            _ => true,
        }
    }

    /// `scene`, which [`super::made::made_of_surfaces`] has made, with this error of `amount`, in the operand's unit, beside those it has.
    ///
    /// # Errors
    /// When the prism cannot have it.
    pub fn put_into(self, scene: &Scene, amount: f64) -> Result<Scene, Error> {
        if !self.acts_on(&scene.prism) {
            let rule = format!("a {} prism has no {}", scene.prism.kind(), self.name());
            return Err(Error::new(format!("scene {}", scene.name), rule, "leave this operand out"));
        }
        let mut scene = scene.clone();
        match (self, &mut scene.prism) {
            (Self::Radius1, PrismSpec::Polynomial(prism)) => prism.front = with_radius(&prism.front, amount),
            (Self::Radius2, PrismSpec::Polynomial(prism)) => prism.back = with_radius(&prism.back, amount),
            (Self::FacetAngle, PrismSpec::Polynomial(prism)) => {
                prism.front = steeper(&prism.front, amount.to_radians())
            }
            (Self::FacetAngle, PrismSpec::Flat(flat)) => {
                flat.facet_angle_rad = flat.facet_angle_rad.map(|angle| angle + amount.to_radians());
            }
            (Self::FacetAngle, PrismSpec::Revolved(prism)) => {
                prism.front = turned_patch(&prism.front, amount.to_radians());
            }
            (Self::FacetAngle, PrismSpec::Mesh(mesh)) => {
                mesh.front = turned_triangles(&mesh.front, amount.to_radians());
                if let Some([front, _]) = &mut mesh.left {
                    *front = turned_triangles(front, -amount.to_radians());
                }
            }
            _ => {
                let mut errors = scene.effects.manufacture.take().unwrap_or_default();
                self.add(&mut errors, amount);
                scene.effects.manufacture = Some(errors);
            }
        }
        Ok(scene)
    }

    /// Adds the error to those of making a prism.
    fn add(self, errors: &mut Manufacture, amount: f64) {
        let turn = |place: &mut Displacement, axis: DVec3| place.tilt_rad += axis * amount.to_radians();
        let shift = |place: &mut Displacement, axis: DVec3| place.decentre_mm += axis * amount;
        match self {
            Self::Thickness => errors.thickness_mm += amount,
            Self::Index => errors.index += amount,
            Self::DecentreX => shift(&mut errors.prism, DVec3::X),
            Self::DecentreY => shift(&mut errors.prism, DVec3::Y),
            Self::Ridge => shift(&mut errors.front.place, DVec3::X),
            Self::DecentreX2 => shift(&mut errors.back.place, DVec3::X),
            Self::DecentreY2 => shift(&mut errors.back.place, DVec3::Y),
            Self::TiltX | Self::TiltY => {
                let axis = if self == Self::TiltX { DVec3::X } else { DVec3::Y };
                turn(&mut errors.front.place, axis);
                turn(&mut errors.back.place, axis);
            }
            Self::TiltX1 => turn(&mut errors.front.place, DVec3::X),
            Self::TiltY1 => turn(&mut errors.front.place, DVec3::Y),
            Self::Roll => turn(&mut errors.prism, DVec3::Z),
            Self::Roll2 => turn(&mut errors.back.place, DVec3::Z),
            Self::Radius1 | Self::Radius2 | Self::FacetAngle => {}
        }
    }
}
