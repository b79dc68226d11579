//! The surfaces of a prism as Extended Polynomial surfaces of OpticStudio, as a text of their parameters.

use super::half_surface::{HalfSurface, designed, no};
use crate::error::Error;
use crate::num::poly2::Poly2;
use crate::system::System;
use glam::{DVec2, DVec3};
use std::fmt::Write;

/// The parameter that holds the first term.
const FIRST_TERM: usize = 15;
/// Places along each side of a surface's domain at which it is held against its terms.
const PLACES: usize = 33;
/// Terms may be off by this much, in mm: a hundredth of the residual that a found hit may have at the finest level.
const MOST_DEPARTURE_MM: f64 = 1e-11;

/// A surface of the right half by its parameters: x as in the prism's frame, y the other way round, as y is up there, both from
/// the prism's axis.
#[derive(Debug, Clone)]
pub struct ExtendedPolynomial {
    /// z of the vertex in the prism's frame, in mm.
    pub vertex_mm: f64,
    /// The normalisation radius, in mm: a power of 2, so that it rounds nothing.
    pub radius_mm: f64,
    /// Powers of x and y, and the coefficient in mm, from parameter 15 on.
    pub terms: Vec<([usize; 2], f64)>,
    /// How far the terms are from the surface in its domain, in mm: the largest of what is found over a grid.
    pub departure_mm: f64,
    /// The surface.
    surface: HalfSurface,
}

impl ExtendedPolynomial {
    fn new(surface: HalfSurface) -> Result<Self, Error> {
        // Count from the axis, in units of one length.
        let reach = surface.domain.min.abs().max(surface.domain.max.abs()).max_element();
        let radius_mm = libm::scalbn(1.0, libm::ceil(libm::log2(reach)) as i32);
        let sag = surface.sag.about([0.0; 2], radius_mm);

        // Order the terms x, y, x^2, xy, y^2, ..., and turn y round.
        let mut terms: Vec<([usize; 2], f64)> = sag.terms().map(|(m, n, c)| ([m, n], c)).collect();
        terms.sort_by_key(|([m, n], _)| [m + n, *n]);
        let vertex_mm = terms.remove(0).1;
        terms.iter_mut().filter(|([_, n], _)| n % 2 == 1).for_each(|(_, c)| *c = 0.0 - *c);
        while terms.len() > 1 && terms.last().is_some_and(|(_, c)| *c == 0.0) {
            terms.pop();
        }
        let departure_mm = departure_mm(&sag, &surface);
        if departure_mm > MOST_DEPARTURE_MM {
            let rule =
                format!("terms about the axis of the prism, in f64, depart from the surfaces by {departure_mm:.1e} mm");
            return Err(no(rule, "take zemax-grid, or design it with a lower degree"));
        }
        Ok(Self { vertex_mm, radius_mm, terms, departure_mm, surface })
    }

    /// Parameters, a line each: number, value, and what it is.
    fn parameters(&self) -> String {
        let mut text =
            format!("13\t{}\tnumber of terms\n14\t{:?}\tnormalisation radius, mm\n", self.terms.len(), self.radius_mm);
        for (k, ([m, n], c)) in self.terms.iter().enumerate() {
            writeln!(text, "{}\t{c:?}\tx^{m} y^{n}", FIRST_TERM + k).expect("writing to a string cannot fail");
        }
        text
    }
}

fn departure_mm(sag: &Poly2, surface: &HalfSurface) -> f64 {
    let share = |k: usize| k as f64 / (PLACES - 1) as f64;
    let places = (0..PLACES * PLACES).map(|k| DVec2::new(share(k % PLACES), share(k / PLACES)));
    let places = places.map(|place| surface.domain.min + surface.domain.size() * place);
    places.map(|at| (sag.value(at.x, at.y) - surface.sag.value(at.x, at.y)).abs()).fold(0.0, f64::max)
}

/// The prism as two such surfaces, with what is around them.
#[derive(Debug, Clone)]
pub struct ExtendedPrism {
    /// Front and back.
    pub surfaces: [ExtendedPolynomial; 2],
    /// Index around the glass, and of the glass.
    indices: [f64; 2],
    /// The camera's pinhole in the prism's frame, in mm.
    pinhole_mm: DVec3,
}

impl ExtendedPrism {
    /// The right half of the prism as it is meant to be.
    ///
    /// # Errors
    /// Without a prism, where a ray on the way of the right half ends, of surfaces that are no polynomials, and where the terms of a
    /// surface, counted from the axis of the prism, lose its digits.
    pub fn new(system: &System) -> Result<Self, Error> {
        let [front, back] = HalfSurface::both(system, "zemax-extended")?;
        let prism = designed(system)?;
        Ok(Self {
            surfaces: [ExtendedPolynomial::new(front)?, ExtendedPolynomial::new(back)?],
            indices: prism.indices(),
            pinhole_mm: prism.prism_from_world().point(system.camera().position_mm()),
        })
    }

    /// The text of the prism of the scene `name`: how its surfaces are entered, and their parameters.
    pub fn text(&self, name: &str) -> String {
        let Self { surfaces: [front, back], indices: [outer, glass], pinhole_mm: pinhole } = self;
        let mut text = format!(
            "The right half of the prism of the scene {name:?} as two Extended Polynomial surfaces of OpticStudio, sequential mode\n\n\
             1. Lens units are mm. x is that of the prism's frame, y its opposite (there it runs up), z runs from the camera to the scene.\n\
             2. Two surfaces of the type Extended Polynomial, one behind the other; radius infinity, conic 0.\n\
             3. The pinhole is at ({:?}, {:?}) mm; from its plane to the vertex of the front: thickness {:?} mm, of index {outer:?}.\n\
             4. From the vertex of the front to that of the back: thickness {:?} mm, a glass of index {glass:?} (Model or fictitious glass).\n\
             5. Behind the back: index {outer:?}.\n\
             6. The parameters of each surface as below, from 13 on; parameters 1 to 12 stay 0.\n\
             7. Give each surface the rectangular aperture below: a polynomial means nothing beyond it.\n\
             8. The left half is the mirror image: the sign of every term with an odd power of x changes.\n",
            pinhole.x,
            0.0 - pinhole.y,
            front.vertex_mm - pinhole.z,
            back.vertex_mm - front.vertex_mm
        );
        for (face, surface) in [("front", front), ("back", back)] {
            let domain = surface.surface.domain;
            write!(
                text,
                "\n[{face}]\nvertex z, mm\t{:?}\naperture, mm\tx {:?} to {:?}, y {:?} to {:?}\n{}",
                surface.vertex_mm,
                domain.min.x,
                domain.max.x,
                -domain.max.y,
                -domain.min.y,
                surface.parameters()
            )
            .expect("writing to a string cannot fail");
        }
        text
    }
}
