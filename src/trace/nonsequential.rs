//! Light through a piece of glass whose every surface parts it: what is let through and what is sent back are both
//! followed, by no chance, until they leave, are absorbed, or are given up; and what became of all of it is accounted for.

use crate::geom::Ray;
use crate::optics::fate::Fate;
use crate::optics::fresnel::{Interface, Layer, left_after};
use crate::optics::polarisation::Beam;
use crate::optics::snell::refract;
use crate::optics::surface::Meeting;
use glam::DVec3;

/// A surface of a biprism, each a graph z(x, y) in the prism's frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Face {
    /// 0 for x < 0, 1 for x >= 0.
    pub side: usize,
    /// 0 for the facet that faces the camera, 1 for the back.
    pub which: usize,
}

/// What the glass is made of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Body {
    /// Refractive index of the surroundings.
    pub n_outer: f64,
    /// Refractive index of the glass.
    pub n_glass: f64,
    /// Layers on the facets and on the backs.
    pub layers: [Option<Layer>; 2],
    /// Wavelength in vacuum, in nm; only layers ask for it.
    pub wavelength_nm: f64,
    /// Absorption coefficient of the glass, in 1/mm.
    pub absorption_per_mm: f64,
}

/// When light is given up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Light that has been reflected more often than this.
    pub bounces: u32,
    /// Light of less power than this, of 1 that came in.
    pub least_power: f64,
}

/// Light that has left the glass for good.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exit {
    /// The way it goes on, in the prism's frame.
    pub ray: Ray,
    /// Its power, of 1 that came in.
    pub power: f64,
    /// How often it was reflected.
    pub bounces: u32,
    /// The face that it left last.
    pub face: Face,
}

/// What became of the power that came in; the three add up to it.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Account {
    /// Left the glass for good, either way.
    pub escaped: f64,
    /// Absorbed in the glass.
    pub absorbed: f64,
    /// Given up by the limits, gone where the glass has no surface, or lost by a solver.
    pub dropped: f64,
}

/// Slack of the test on which side of the ridge a ray meets a facet, as a share of its way: a few roundings.
const RIDGE_ROUNDINGS: f64 = 8.0 * f64::EPSILON;

/// A piece of glass between four faces, of which `meet` says where a ray first meets one.
///
/// The right face counts where x >= 0, the left one where x <= 0. A back counts everywhere for light that met a facet of its
/// own side last, as it does for light that passes in sequence. A face never sees itself: it is less bent than the light on
/// it is inclined, as it is where [`crate::optics::surface::Freeform`] knows that a ray crosses it once.
#[derive(Debug)]
pub struct Solid<M> {
    /// What it is made of.
    pub body: Body,
    /// Where a ray in the prism's frame first meets a face, with the normal in either orientation.
    pub meet: M,
}

/// Light on its way.
#[derive(Clone, Copy)]
struct Branch {
    ray: Ray,
    beam: Beam,
    bounces: u32,
    /// The face where it starts; `None` at first.
    from: Option<Face>,
    inside: bool,
    /// The side whose facet it met last.
    side: usize,
}

/// What a ray comes to next.
enum Next {
    Meets(Face, Meeting),
    Escapes,
    Lost,
}

impl<M: Fn(Face, &Ray) -> Result<Meeting, Fate>> Solid<M> {
    /// Follows light of power 1 that comes along `ray` towards the facets: `leave` hears of all that leaves the glass,
    /// in a fixed order.
    ///
    /// `start` is the beam along the ray. The glass is met again by light that left a facet towards the camera and
    /// meets the other facet; light that has left through a back is gone.
    pub fn follow(&self, ray: &Ray, start: Beam, limits: Limits, leave: &mut impl FnMut(&Exit)) -> Account {
        let mut account = Account::default();
        let side = usize::from(ray.direction.x >= 0.0);
        let branch = Branch { ray: *ray, beam: start, bounces: 0, from: None, inside: false, side };
        self.walk(branch, limits, &mut account, leave);
        account
    }

    fn walk(&self, branch: Branch, limits: Limits, account: &mut Account, leave: &mut impl FnMut(&Exit)) {
        let power = branch.beam.power();
        if branch.bounces > limits.bounces || power < limits.least_power {
            account.dropped += power;
            return;
        }
        let (face, meeting) = match (self.next(&branch), branch.from) {
            (Next::Meets(face, meeting), _) => (face, meeting),
            (Next::Escapes, Some(face)) => {
                account.escaped += power;
                leave(&Exit { ray: branch.ray, power, bounces: branch.bounces, face });
                return;
            }
            (Next::Lost, _) | (Next::Escapes, None) => {
                account.dropped += power;
                return;
            }
        };
        let mut beam = branch.beam;
        if branch.inside && self.body.absorption_per_mm != 0.0 {
            beam = beam.dimmed(left_after(self.body.absorption_per_mm, meeting.t_mm));
            account.absorbed += power - beam.power();
        }
        let (incoming, normal) = (branch.ray.direction, meeting.normal);
        let reflected = (incoming - normal * (2.0 * incoming.dot(normal))).normalize();
        let interface = self.interface(face, branch.inside);
        let refracted = refract(incoming, normal, interface.n_in / interface.n_out).map(|r| r.direction);
        let parts = beam.split(&interface, normal, incoming, reflected, refracted);
        let origin = branch.ray.at(meeting.t_mm);
        let side = if face.which == 0 { face.side } else { branch.side };
        let onward = Branch { from: Some(face), side, ..branch };
        if let Some(direction) = refracted {
            let ray = Ray { origin, direction };
            self.walk(
                Branch { ray, beam: parts.transmitted, inside: !branch.inside, ..onward },
                limits,
                account,
                leave,
            );
        }
        let ray = Ray { origin, direction: reflected };
        self.walk(Branch { ray, beam: parts.reflected, bounces: branch.bounces + 1, ..onward }, limits, account, leave);
    }

    /// The face as light meets it from inside or outside.
    fn interface(&self, face: Face, inside: bool) -> Interface {
        let Body { n_outer, n_glass, layers, wavelength_nm, .. } = self.body;
        let (n_in, n_out) = if inside { (n_glass, n_outer) } else { (n_outer, n_glass) };
        Interface { n_in, n_out, layer: layers[face.which].map(|layer| (layer, wavelength_nm)) }
    }

    fn next(&self, branch: &Branch) -> Next {
        // Through the back there is nothing more to meet.
        if !branch.inside && branch.from.is_some_and(|face| face.which == 1) {
            return Next::Escapes;
        }
        // The nearest facet on its own half, the right one at the same distance; a ray through the ridge itself, which to
        // within rounding is on neither half, meets the right one.
        let mut nearest: Option<(Half, Face, Meeting)> = None;
        let faces = [Face { side: 1, which: 0 }, Face { side: 0, which: 0 }, Face { side: branch.side, which: 1 }];
        let back = if branch.inside { 3 } else { 2 };
        for face in &faces[..back] {
            let itself = branch.from.is_some_and(|from| if face.which == 1 { from.which == 1 } else { from == *face });
            if itself {
                continue;
            }
            let meeting = match (self.meet)(*face, &branch.ray) {
                Ok(meeting) => meeting,
                Err(Fate::NotConverged) => return Next::Lost,
                Err(_) => continue,
            };
            let Some(half) = half(&branch.ray, branch.inside, *face, &meeting) else { continue };
            let nearer = nearest.is_none_or(|(other, met, m)| match (other, half) {
                (Half::Ridge, Half::Own) if met.which == face.which => true,
                (Half::Own, Half::Ridge) if met.which == face.which => false,
                (Half::Ridge, Half::Ridge) => false,
                _ => meeting.t_mm < m.t_mm,
            });
            if nearer {
                nearest = Some((half, *face, meeting));
            }
        }
        match nearest {
            Some((_, face, meeting)) => Next::Meets(face, meeting),
            // Inside, the rim of the glass.
            None if branch.inside => Next::Lost,
            None => Next::Escapes,
        }
    }
}

/// Where a face was met.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Half {
    /// Where it counts.
    Own,
    /// In the ridge, to within rounding.
    Ridge,
}

/// Where a face was met, if it is there and is met from the side on which the light is. This, and not a least distance,
/// keeps light from meeting again what it has just left.
fn half(ray: &Ray, inside: bool, face: Face, meeting: &Meeting) -> Option<Half> {
    let upwards: DVec3 = meeting.normal * meeting.normal.z.signum();
    let along = ray.direction.dot(upwards);
    // Glass is behind the facets, in +z, and in front of the backs.
    let into_glass = if face.which == 0 { along } else { -along };
    if along == 0.0 || (into_glass < 0.0) != inside {
        return None;
    }
    let x = ray.at(meeting.t_mm).x;
    let own = match face {
        Face { which: 1, .. } => true,
        Face { side: 1, .. } => x >= 0.0,
        _ => x < 0.0,
    };
    let slack = RIDGE_ROUNDINGS * (ray.origin.x.abs() + meeting.t_mm);
    if own { Some(Half::Own) } else { (x.abs() <= slack).then_some(Half::Ridge) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Rect;
    use crate::num::poly2::Poly2;
    use crate::optics::fresnel::Polarisation;
    use crate::optics::mesh::{Mesh, Normals, Triangles};
    use crate::optics::polarisation::Light;
    use crate::optics::surface::{Freeform, Patch, Surface};
    use glam::DVec2;
    use proptest::prelude::*;

    const GLASS: Body =
        Body { n_outer: 1.0, n_glass: 1.48, layers: [None; 2], wavelength_nm: 550.0, absorption_per_mm: 0.0 };
    const ALL: Limits = Limits { bounces: 80, least_power: 0.0 };

    /// A biprism with its ridge at (0, 0, 80), 8 mm thick.
    fn faces(facet_rad: f64) -> [[Surface; 2]; 2] {
        let (sin, cos) = libm::sincos(facet_rad);
        let facet =
            |s: f64| Surface::Plane { point: DVec3::new(0.0, 0.0, 80.0), normal: DVec3::new(-s * sin, 0.0, cos) };
        let back = Surface::Plane { point: DVec3::new(0.0, 0.0, 88.0), normal: DVec3::Z };
        [[facet(-1.0), back.clone()], [facet(1.0), back]]
    }

    fn meet(faces: &[[Surface; 2]; 2]) -> impl Fn(Face, &Ray) -> Result<Meeting, Fate> {
        move |face, ray| faces[face.side][face.which].meet(ray, 1e-12)
    }

    fn towards(x: f64, y: f64) -> Ray {
        Ray { origin: DVec3::ZERO, direction: DVec3::new(x, y, 80.0).normalize() }
    }

    fn exits(body: Body, faces: &[[Surface; 2]; 2], ray: &Ray, light: Light, limits: Limits) -> (Account, Vec<Exit>) {
        let mut found = Vec::new();
        let start = Beam::new(ray.direction, light);
        let account = Solid { body, meet: meet(faces) }.follow(ray, start, limits, &mut |exit| found.push(*exit));
        (account, found)
    }

    /// A plate of thickness 8: the k-th ghost has been reflected 2 k times, has the power T^2 R^2k, and is moved sideways by
    /// 2 k T tan(r) along the plate (Born & Wolf, 7.6.1).
    #[test]
    fn ghosts_of_a_plate_have_their_closed_form() {
        let ray = towards(0.0, 30.0);
        let (account, found) = exits(GLASS, &faces(0.0), &ray, Light::X, ALL);
        let cos_in = ray.direction.z;
        // The plane of incidence is y-z, so that light along x is s.
        let shares = Interface::bare(1.0, 1.48).shares(Polarisation::S, cos_in);
        let (r, t) = (shares.reflected, shares.transmitted);
        let sin = (1.0 - cos_in * cos_in).sqrt() / 1.48;
        let tan = sin / (1.0 - sin * sin).sqrt();
        let through: Vec<&Exit> = found.iter().filter(|e| e.face.which == 1).collect();
        for (k, exit) in through.iter().take(5).enumerate() {
            assert_eq!(exit.bounces, 2 * k as u32);
            let expected = t * t * libm::pow(r * r, k as f64);
            assert!((exit.power / expected - 1.0).abs() < 1e-13, "{k}: {} {expected}", exit.power);
            let y = 30.0 + 8.0 * tan * (2 * k + 1) as f64;
            assert!((exit.ray.origin - DVec3::new(0.0, y, 88.0)).length() < 1e-12);
            assert!((exit.ray.direction - ray.direction).length() < 1e-15);
        }
        // All of them, and all that is sent back: (1 - R) / (1 + R) and 2 R / (1 + R).
        let sum = |which: usize| -> f64 { found.iter().filter(|e| e.face.which == which).map(|e| e.power).sum() };
        assert!((sum(1) - (1.0 - r) / (1.0 + r)).abs() < 1e-14 && (sum(0) - 2.0 * r / (1.0 + r)).abs() < 1e-14);
        assert!((account.escaped - 1.0).abs() < 1e-14 && account.dropped < 1e-100);
    }

    /// An absorbing plate met along its normal: A = (1 - R) (1 - e) / (1 - R e), with e left after one way.
    #[test]
    fn an_absorbing_plate_has_its_closed_form() {
        let body = Body { absorption_per_mm: 0.05, ..GLASS };
        let ray = towards(0.0, 0.0);
        let (account, _) = exits(body, &faces(0.0), &ray, Light::Unpolarised, ALL);
        let (r, e): (f64, f64) = ((0.48f64 / 2.48) * (0.48 / 2.48), left_after(0.05, 8.0));
        assert!((account.absorbed - (1.0 - r) * (1.0 - e) / (1.0 - r * e)).abs() < 1e-14);
        let back = r + (1.0 - r) * (1.0 - r) * r * e * e / (1.0 - r * r * e * e);
        let through = (1.0 - r) * (1.0 - r) * e / (1.0 - r * r * e * e);
        assert!((account.escaped - back - through).abs() < 1e-14);
    }

    /// The first ghost of a wedge: two reflections in mirrors at the angle a turn the light by 2 a inside the glass, and
    /// Snell's law at the back makes that the angle of emergence.
    #[test]
    fn the_ghost_of_a_wedge_is_turned_by_twice_its_angle() {
        let a = 0.1545;
        let (_, found) = exits(GLASS, &faces(a), &towards(4.0, 0.0), Light::Y, Limits { bounces: 2, ..ALL });
        let through: Vec<&Exit> = found.iter().filter(|e| e.face.which == 1).collect();
        let inner = |exit: &Exit| libm::asin(exit.ray.direction.x / 1.48);
        assert_eq!(through.iter().map(|e| e.bounces).collect::<Vec<_>>(), [0, 2]);
        // The right facet rises with x: its normal leans towards -x, and so does the ghost.
        assert!((inner(through[0]) - inner(through[1]) - 2.0 * a).abs() < 1e-14);
    }

    /// Beyond the critical angle nothing gets through, nothing is lost, and the light goes on inside.
    #[test]
    fn total_reflection_keeps_the_power() {
        // Steep facets turn the light so far that the back reflects it whole.
        let body = Body { n_glass: 1.9, ..GLASS };
        let (account, found) = exits(body, &faces(1.2), &towards(1.0, 0.5), Light::Unpolarised, ALL);
        assert!(
            found.iter().all(|e| !(e.face.which == 1 && e.bounces == 0)),
            "the first meeting with the back is total"
        );
        assert!((account.escaped + account.absorbed + account.dropped - 1.0).abs() < 1e-13);
        assert!(account.escaped > 1.0 - 1e-12, "it finds its way out: {account:?}");
    }

    #[test]
    fn limits_give_up_light_and_say_how_much() {
        let faces = faces(0.15);
        let ray = towards(5.0, 1.0);
        let (none, found) = exits(GLASS, &faces, &ray, Light::Unpolarised, Limits { bounces: 0, least_power: 0.0 });
        assert_eq!(found.len(), 1, "only the light that is never reflected");
        assert!((none.escaped - found[0].power).abs() < 1e-16 && (none.escaped + none.dropped - 1.0).abs() < 1e-15);
        let (few, kept) = exits(GLASS, &faces, &ray, Light::Unpolarised, Limits { bounces: 80, least_power: 1e-4 });
        assert!(kept.iter().all(|e| e.power >= 1e-4) && few.dropped > 0.0 && few.dropped < 1e-3);
    }

    /// At the ridge and beside it, of a wedge and of a groove, all light that comes back to a facet meets one.
    #[test]
    fn no_light_slips_through_the_ridge() {
        for angle in [0.15, -0.15, 0.6] {
            for x in [0.0, 1e-16, -1e-16, 1e-13, -1e-13, 0.2, -0.2] {
                let (account, found) = exits(GLASS, &faces(angle), &towards(x, 0.3), Light::Unpolarised, ALL);
                // A wedge lets go of all light: 80 reflections of 15 % or less are left. A groove widens, and may trap what it
                // has reflected twice, by 5 % or less each time.
                let bound = if angle > 0.0 { 1e-60 } else { 2.5e-3 };
                assert!(account.dropped < bound, "{angle} {x}: {account:?}");
                for exit in found.iter().filter(|e| e.face.which == 0) {
                    let p = exit.ray.origin;
                    assert!(
                        (p.z - 80.0 - p.x.abs() * libm::tan(angle)).abs() < 1e-12,
                        "{angle} {x}: {p} is on no facet"
                    );
                }
            }
        }
    }

    /// Tessellated planes are planes: the same light leaves at the same places, the nearest face found by a hierarchy.
    #[test]
    fn a_mesh_of_planes_gives_the_light_of_planes() {
        let exact = faces(0.1545);
        let domain = Rect { min: DVec2::new(-25.0, -25.0), max: DVec2::new(25.0, 25.0) };
        let meshes = exact.clone().map(|side| {
            side.map(|surface| {
                let Surface::Plane { point, normal } = surface else { unreachable!("all are planes") };
                let height = |x: f64, y: f64| {
                    (point.z - (normal.x * (x - point.x) + normal.y * (y - point.y)) / normal.z, normal)
                };
                Mesh::new(Triangles::over(domain, 17, height), Normals::Flat)
            })
        });
        let solid = Solid { body: GLASS, meet: |face: Face, ray: &Ray| meshes[face.side][face.which].meet(ray) };
        let limits = Limits { bounces: 4, least_power: 1e-9 };
        let mut compared = 0;
        for k in 0..300 {
            let ray = towards(9.0 * libm::sin(1.7 * k as f64), 7.0 * libm::cos(0.9 * k as f64));
            let (account, wanted) = exits(GLASS, &exact, &ray, Light::Unpolarised, limits);
            let mut found = Vec::new();
            let start = Beam::new(ray.direction, Light::Unpolarised);
            let by_mesh = solid.follow(&ray, start, limits, &mut |exit| found.push(*exit));
            assert_eq!(found.len(), wanted.len(), "{ray:?}");
            for (a, b) in found.iter().zip(&wanted) {
                assert_eq!((a.bounces, a.face), (b.bounces, b.face));
                // Corners of triangles round to 1e-14 mm, over edges of 3 mm.
                assert!((a.ray.origin - b.ray.origin).length() < 1e-11 && (a.power - b.power).abs() < 1e-12);
                compared += 1;
            }
            assert!((by_mesh.dropped - account.dropped).abs() < 1e-12);
        }
        assert!(compared > 1500);
    }

    fn bent() -> [[Surface; 2]; 2] {
        let domain = Rect { min: DVec2::new(-2.0, -15.0), max: DVec2::new(22.0, 15.0) };
        let sheet = |constant: f64, slope: f64, bend: f64| {
            let sag = Poly2::new(2, [0.0, 0.0], [1.0, 1.0], move |m, n| match (m, n) {
                (0, 0) => constant,
                (1, 0) => slope,
                (2, 0) | (0, 2) => bend,
                _ => 0.0,
            });
            Patch { sag, domain }
        };
        [true, false].map(|mirrored| {
            [sheet(80.0, 0.15, 1e-3), sheet(88.0, 0.0, -7e-4)].map(|p| Surface::Freeform(Freeform::new(&p, mirrored)))
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(1500))]

        /// escaped + absorbed + dropped = 1, whatever the glass, the coating, the shape and the limits, at the ridge and
        /// far from it.
        #[test]
        fn no_power_is_lost(
            (n_outer, n_glass) in (1.0..2.0f64, 1.0..3.0f64),
            angle in prop_oneof![Just(0.0), -1.2..1.2f64],
            (x, y) in (prop_oneof![Just(0.0), Just(1e-16), -1e-12..1e-12f64, -30.0..30.0f64], -30.0..30.0f64),
            absorption_per_mm in prop_oneof![Just(0.0), 0.0..0.3f64],
            layer in prop::option::of((1.0..2.5f64, 0.0..500.0f64)),
            (bounces, exponent) in (0..12u32, -12.0..-1.0f64),
            curved in any::<bool>(),
        ) {
            let layer = layer.map(|(index, thickness_nm)| Layer { index, thickness_nm });
            let body = Body { n_outer, n_glass, layers: [layer; 2], wavelength_nm: 550.0, absorption_per_mm };
            let faces = if curved { bent() } else { faces(angle) };
            let limits = Limits { bounces, least_power: libm::pow(10.0, exponent) };
            let (account, found) = exits(body, &faces, &towards(x, y), Light::Unpolarised, limits);
            let Account { escaped, absorbed, dropped } = account;
            prop_assert!((escaped + absorbed + dropped - 1.0).abs() < 1e-12, "{account:?}");
            prop_assert!(escaped >= 0.0 && absorbed >= 0.0 && dropped >= 0.0);
            let sum: f64 = found.iter().map(|e| e.power).sum();
            prop_assert!((sum - escaped).abs() < 1e-14);
            for exit in &found {
                prop_assert!(exit.bounces <= bounces && exit.ray.direction.is_finite() && exit.ray.origin.is_finite());
            }
        }
    }
}
