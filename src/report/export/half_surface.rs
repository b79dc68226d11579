//! The surfaces of the right half of a prism that are polynomials.

use crate::error::Error;
use crate::geom::Rect;
use crate::num::poly2::Poly2;
use crate::surface::face::Face;
use crate::surface::shape::Surface;
use crate::system::tessellated::used_part;
use crate::system::{Prism, Side, System};

/// A surface of the right half, z(x, y) in mm in the prism's frame.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct HalfSurface {
    /// z(x, y).
    pub(super) sag: Poly2,
    /// Where it is given, or of a plane what the rays of the picture meet of it.
    pub(super) domain: Rect,
}

impl HalfSurface {
    /// Front and back of the prism as it is meant to be: planes are polynomials of degree 1.
    ///
    /// # Errors
    /// Without a prism, where a ray on the way of the right half ends, and of surfaces that are no polynomials, for the `format` that
    /// needs them.
    pub(super) fn both(system: &System, format: &str) -> Result<[Self; 2], Error> {
        let prism = designed(system)?;
        let used = used(system)?;
        let of = |face: Face| match prism.surface(Side::Right, face) {
            Surface::Plane { point, normal } => {
                let slope = -normal.truncate() / normal.z;
                let height = point.z - slope.dot(point.truncate());
                let term = |m: usize, n: usize| [height, slope.x, slope.y][m + 2 * n];
                Ok(Self { sag: Poly2::new(1, [0.0; 2], [1.0; 2], term), domain: used[face as usize] })
            }
            Surface::Freeform(sheet) => Ok(Self { sag: sheet.sag().clone(), domain: sheet.domain() }),
            Surface::Revolved(_) => Err(no(
                format!("the prism's surfaces are of revolution, and `--format {format}` takes polynomials"),
                "take zemax-grid or a solid, or design it with `biprism design --surface polynomial`",
            )),
            _ => Err(no(
                format!("the prism's surfaces are triangles, and `--format {format}` takes polynomials"),
                "take stl, ply or obj, or fit polynomials to its points with `kind = \"point_cloud\"`",
            )),
        };
        Ok([of(Face::Front)?, of(Face::Back)?])
    }
}

/// The prism of an instrument as it is meant to be.
pub(super) fn designed(system: &System) -> Result<&Prism, Error> {
    system.designed().ok_or_else(|| no("the scene has no prism".to_owned(), "give the scene a prism of two surfaces"))
}

/// The rectangles that hold what the rays of the right half meet of front and back.
pub(super) fn used(system: &System) -> Result<[Rect; 2], Error> {
    let ends = || {
        no("a ray of the right half ends before it has passed the prism".to_owned(), "run `biprism check` on the scene")
    };
    used_part(system).ok_or_else(ends)
}

pub(super) fn no(rule: String, help: &str) -> Error {
    Error::new("the prism", rule, help)
}
