//! The prism as built, from the nominal prism.

use super::biprism::Prism;
use super::side::Side;
use crate::effect::Manufacture;
use crate::geom::Pose;
use crate::surface::face::Face;
use crate::surface::shape::Surface;
use glam::DVec3;
use std::sync::Arc;

impl Prism {
    /// This prism with errors: figures first, then every surface moved to where it is. The frame of the prism goes with
    /// the front, whose ridge parts the two sides.
    #[must_use]
    pub(super) fn made(&self, errors: &Manufacture) -> Self {
        let pivots = Face::ALL.map(|face| DVec3::Z * self.vertex_z_mm(face));
        let front = errors.front.place.about(pivots[0]);
        let mut back = errors.back.place.about(pivots[1]);
        back.translation_mm.z += errors.thickness_mm;
        let front_from_back = front.inverse().after(&back);
        let sides = Side::ALL.map(|side| {
            let [front, back] = Face::ALL.map(|face| {
                let error = match face {
                    Face::Front => &errors.front,
                    Face::Back => &errors.back,
                };
                let surface = self.surface(side, face).clone();
                match error.figure.as_ref().filter(|figure| !figure.is_nothing()) {
                    None => surface,
                    Some(figure) => Surface::Flawed { base: Box::new(surface), flaw: Arc::new(figure.clone()) },
                }
            });
            let back = if front_from_back.is_identity() { back } else { back.moved(front_from_back) };
            [front, back]
        });
        let world_from_prism = self.poses.map_or(Pose::IDENTITY, |[pose, _]| pose);
        let world_from_front = world_from_prism.after(&errors.prism.about(pivots[0])).after(&front);
        let poses = (!world_from_front.is_identity()).then(|| [world_from_front, world_from_front.inverse()]);
        self.with_index_shift(errors.index).rebuilt(poses, sides)
    }

    /// z of the front or the back over the origin of the prism's frame, in mm.
    fn vertex_z_mm(&self, face: Face) -> f64 {
        self.surface(Side::Right, face).height_mm(0.0, 0.0)
    }
}
