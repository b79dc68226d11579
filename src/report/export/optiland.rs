//! A half of a prism, its camera and its board as a lens file of Optiland (<https://github.com/HarrisonKramer/optiland>).

use super::half_surface::{HalfSurface, designed, no};
use crate::error::Error;
use crate::geom::Pose;
use crate::num::poly2::Poly2;
use crate::system::{Side, System};
use glam::{DVec2, DVec3};
use serde_json::{Value, json};

/// The radius of a surface without curvature of its own: its sphere rises by less than 1e-26 mm. JSON has no infinity.
const FLAT_RADIUS_MM: f64 = 1e30;
/// Optiland's Newton method ends when a hit is so near, in mm.
const HIT_MM: f64 = 1e-14;
/// Its steps at most.
const MOST_STEPS: usize = 100;
/// Where along z between pinhole and prism the stop lies: Optiland aims at it.
const STOP: f64 = 0.5;

/// An instrument of which Optiland's files of both halves are made.
#[derive(Debug, Clone)]
pub struct OptilandPrism<'a> {
    system: &'a System,
    /// Front and back of the right half.
    right: [HalfSurface; 2],
    /// Index around the glass, and of the glass.
    indices: [f64; 2],
    prism_from_world: Pose,
}

impl<'a> OptilandPrism<'a> {
    /// The prism as it is meant to be, before camera and board.
    ///
    /// # Errors
    /// Without a prism, where a ray on the way of the right half ends, of surfaces that are no polynomials, and of a telecentric
    /// camera, whose rays come from no point.
    pub fn new(system: &'a System) -> Result<Self, Error> {
        if system.effects().lens.telecentric().is_some() {
            let help = "take the telecentric lens out of the scene, or another format";
            return Err(Error::new("the camera", "the camera is telecentric, and its rays come from no point", help));
        }
        let right = HalfSurface::both(system, "optiland")?;
        let prism = designed(system)?;
        Ok(Self { system, right, indices: prism.indices(), prism_from_world: prism.prism_from_world() })
    }

    /// The file of a half, in the prism's frame: the pinhole as the object's only point, a stop, front, back, and the plane of
    /// the board as the image, whose x and y are those of the board. `wavelength_nm` is that of the index.
    ///
    /// # Errors
    /// Where a ray of the picture's border runs along the board or away from it.
    pub fn json(&self, side: Side, name: &str, wavelength_nm: f64) -> Result<Value, Error> {
        let [outer, glass] = self.indices;
        let pinhole = self.prism_from_world.point(self.system.camera().position_mm());
        let board = self.prism_from_world.after(&self.system.board().pattern.world_from_board);
        let first_z = self.right[0].sag.terms().next().map_or(0.0, |(_, _, c)| c);
        let stop = DVec3::new(0.0, 0.0, pinhole.z + STOP * (first_z - pinhole.z));
        let at = |place: DVec3| cs(place, DVec3::ZERO);
        let plane = |cs: Value| json!({"type": "Plane", "cs": cs});
        let [front, back] = self.right.each_ref().map(|surface| polynomial(&surface.sag, side));
        let object = json!({
            "type": "ObjectSurface",
            "geometry": plane(at(DVec3::new(0.0, 0.0, pinhole.z))),
            "material_post": medium(outer),
            "comment": "the pinhole's plane",
        });
        Ok(json!({
            "version": 1.0,
            "name": name,
            "aperture": {"type": "objectNA", "value": self.aperture(side, outer)?},
            "fields": {
                "fields": [{"x": pinhole.x, "y": pinhole.y, "vx": 0.0, "vy": 0.0, "weight": 1.0}],
                "telecentric": false,
                "field_definition": {"field_type": "ObjectHeightField"},
            },
            "wavelengths": {
                "wavelengths": [{"value": 1e-3 * wavelength_nm, "is_primary": true, "unit": "um", "weight": 1.0}],
                "polarization": "ignore",
            },
            "apodization": null,
            "pickups": [],
            "solves": {"solves": []},
            "surface_group": {"surfaces": [
                object,
                surface(plane(at(stop)), outer, true, "stop"),
                surface(front, glass, false, "front"),
                surface(back, outer, false, "back"),
                surface(plane(cs(board.translation_mm, board.angles_rad())), outer, false, "board"),
            ]},
            "ray_tracer": {"ray_aiming_config": {"mode": "paraxial", "max_iter": 10, "tol": 1e-6}},
        }))
    }

    /// The numerical aperture of the cone about +z from the pinhole that holds all rays of a half.
    fn aperture(&self, side: Side, outer: f64) -> Result<f64, Error> {
        let camera = self.system.camera();
        let [width, height] = camera.size_px().map(|n| n as f64);
        let columns = if side == Side::Left { [0.0, 0.5 * width] } else { [0.5 * width, width] };
        let corners = columns.into_iter().flat_map(|x| [0.0, height].map(|y| DVec2::new(x, y)));
        let directions = corners.map(|px| self.prism_from_world.vector(camera.ray(px).direction));
        let sine = directions.map(|d| d.truncate().length() / d.length()).fold(0.0, f64::max);
        if sine.is_finite() && sine > 0.0 {
            Ok(outer * sine)
        } else {
            Err(no("no cone holds the rays of a half of the picture".to_owned(), "run `biprism check` on the scene"))
        }
    }
}

/// Where a surface's own frame stands: turned about the fixed x, then y, then z axis, then moved.
fn cs(place: DVec3, angles_rad: DVec3) -> Value {
    json!({
        "x": place.x, "y": place.y, "z": place.z,
        "rx": angles_rad.x, "ry": angles_rad.y, "rz": angles_rad.z,
        "reference_cs": null,
    })
}

/// A polynomial about its own centre in powers of mm, of the right half or its mirror image; its constant is the place of the vertex.
fn polynomial(sag: &Poly2, side: Side) -> Value {
    let sag = if side == Side::Left { sag.mirrored() } else { sag.clone() };
    let ([x, y], [sx, sy], size) = (sag.centre(), sag.scale(), sag.degree() + 1);
    let mut coefficients = vec![vec![0.0; size]; size];
    for (m, n, c) in sag.terms() {
        let lengths = (0..m).fold(1.0, |p, _| p * sx) * (0..n).fold(1.0, |p, _| p * sy);
        coefficients[m][n] = c / lengths;
    }
    let z = std::mem::take(&mut coefficients[0][0]);
    json!({
        "type": "PolynomialGeometry",
        "cs": cs(DVec3::new(x, y, z), DVec3::ZERO),
        "radius": FLAT_RADIUS_MM,
        "conic": 0.0,
        "tol": HIT_MM,
        "max_iter": MOST_STEPS,
        "coefficients": coefficients,
    })
}

fn medium(index: f64) -> Value {
    json!({
        "type": "IdealMaterial",
        "propagation_model": {"class": "HomogeneousPropagation"},
        "index": index,
        "absorp": 0.0,
    })
}

fn surface(geometry: Value, index_behind: f64, is_stop: bool, comment: &str) -> Value {
    json!({
        "type": "Surface",
        "thickness": 0.0,
        "geometry": geometry,
        "material_post": medium(index_behind),
        "is_stop": is_stop,
        "aperture": null,
        "comment": comment,
        "interaction_model": {"type": "RefractiveReflectiveModel", "is_reflective": false, "coating": null, "bsdf": null},
    })
}
