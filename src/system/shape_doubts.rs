//! What the surfaces of a user's prism look like that they should not: doubts that need no ray.

use super::instrument::System;
use crate::geom::{Ray, Rect};
use crate::prism::biprism::Prism;
use crate::prism::side::Side;
use crate::scene::{MeshSpec, Normals, PrismSpec, Scene, Triangles};
use crate::surface::closed_body::is_closed;
use crate::surface::face::Face;
use crate::surface::mesh::Mesh;
use crate::surface::shape::{PolynomialSurface, RevolvedSurface, Surface};
use glam::{DVec2, DVec3};

/// A surface that reaches to this share of one half's width into the other holds more than its half.
const OTHER_HALF: f64 = 0.25;
/// The same of one that has no ridge at x = 0.
const MOST_OF_OTHER_HALF: f64 = 0.6;
/// Slopes of the two sides of x = 0 that differ by more than this make a ridge there.
const RIDGE_SLOPE: f64 = 0.02;
/// They are taken between places that are this share of the narrower half apart.
const RIDGE_STEP: f64 = 0.01;
/// A surface whose width is below this, in mm, is no prism's.
const TOO_SMALL_MM: f64 = 1.0;
/// A surface whose width is above this, in mm, is no prism's either.
const TOO_LARGE_MM: f64 = 1000.0;
/// Smooth normals that lean more than this from their triangle stand for a facet, or for too coarse a mesh.
const LARGEST_LEAN_DEG: f64 = 0.8;
/// Places along each axis at which heights are compared.
const PLACES: usize = 12;

/// The region that a surface is given over, in mm in the prism's frame.
#[derive(Debug, Clone, Copy)]
struct Extent {
    min: DVec3,
    max: DVec3,
}

impl Extent {
    fn of(points: impl Iterator<Item = DVec3>) -> Self {
        points.fold(Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY }, |e, p| Self {
            min: e.min.min(p),
            max: e.max.max(p),
        })
    }

    fn words(&self) -> String {
        let range = |name: &str, a: f64, b: f64| format!("{name} {} to {}", short(a), short(b));
        let [x, y, z] = [0, 1, 2].map(|k| range(["x", "y", "z"][k], self.min[k], self.max[k]));
        format!("{x}, {y}, {z} mm")
    }
}

/// A length to four significant digits.
fn short(value: f64) -> String {
    let digits = if value == 0.0 { 0.0 } else { 3.0 - libm::floor(libm::log10(value.abs())) };
    format!("{:.*}", digits.clamp(0.0, 9.0) as usize, value)
}

/// A surface that a user gives: its key, its region, and its shape.
struct Given<'a> {
    key: &'static str,
    extent: Extent,
    shape: Shape<'a>,
}

/// The shape of a surface in the prism's frame.
enum Shape<'a> {
    /// A polynomial that a scene states by its terms.
    Stated(&'a PolynomialSurface),
    /// A surface of revolution that a scene states by its profile.
    Revolved(&'a RevolvedSurface),
    /// A polynomial through points.
    Fitted(&'a PolynomialSurface),
    /// Triangles.
    Mesh(&'a Triangles, &'a Mesh),
}

impl Given<'_> {
    /// z over a place, the lowest of a mesh; `None` where the surface is not given.
    fn height(&self, at: DVec2) -> Option<f64> {
        match self.shape {
            Shape::Stated(sheet) | Shape::Fitted(sheet) => {
                sheet.domain().contains(at).then(|| sheet.sag().value(at.x, at.y))
            }
            Shape::Revolved(part) => part.jet_over(at.x, at.y).map(|jet| jet.value),
            Shape::Mesh(_, mesh) => self.met(mesh, at, DVec3::Z),
        }
    }

    /// Where a vertical ray that comes in `direction` meets a mesh.
    fn met(&self, mesh: &Mesh, at: DVec2, direction: DVec3) -> Option<f64> {
        let z = if direction.z > 0.0 { self.extent.min.z - 1.0 } else { self.extent.max.z + 1.0 };
        let ray = Ray { origin: at.extend(z), direction };
        mesh.intersect(&ray).ok().map(|met| ray.at(met.t_mm).z)
    }

    fn region(&self) -> Rect {
        Rect { min: self.extent.min.truncate(), max: self.extent.max.truncate() }
    }

    /// Whether the surface has a ridge along x = 0.
    fn has_ridge(&self) -> bool {
        let Extent { min, max } = self.extent;
        let h = RIDGE_STEP * max.x.min(-min.x);
        let slope =
            |a: f64, b: f64, y: f64| Some((self.height(DVec2::new(b, y))? - self.height(DVec2::new(a, y))?) / (b - a));
        places(self.region()).any(|DVec2 { y, .. }| {
            let sides = slope(-2.0 * h, -h, y).zip(slope(h, 2.0 * h, y));
            sides.is_some_and(|(left, right)| (right - left).abs() > RIDGE_SLOPE)
        })
    }
}

/// Front and back of the right half as a user gives them; nothing of prisms that are designed or stated by numbers.
fn given<'a>(prism: &'a PrismSpec, built: Option<&'a Prism>) -> Vec<Given<'a>> {
    // Name the keys.
    let keys = match prism {
        PrismSpec::None | PrismSpec::Flat(_) | PrismSpec::Freeform(..) => return Vec::new(),
        PrismSpec::Mesh(MeshSpec { told: Some(_), .. }) => ["prism.body"; 2],
        PrismSpec::Polynomial(_) | PrismSpec::Revolved(_) | PrismSpec::PointCloud(_) | PrismSpec::Mesh(_) => {
            ["prism.front", "prism.back"]
        }
    };

    // Take each surface with the extent of what was given.
    let surface = |face: Face| {
        let shape = match (built?.surface(Side::Right, face), prism) {
            (Surface::Freeform(sheet), PrismSpec::PointCloud(_)) => Shape::Fitted(sheet),
            (Surface::Freeform(sheet), _) => Shape::Stated(sheet),
            (Surface::Revolved(part), _) => Shape::Revolved(part),
            (Surface::Mesh { mesh, .. }, PrismSpec::Mesh(own)) => {
                Shape::Mesh([&own.front, &own.back][face as usize], mesh)
            }
            _ => return None,
        };
        let extent = match (&shape, prism) {
            (Shape::Mesh(own, _), _) => Extent::of(own.points_mm.iter().copied()),
            (_, PrismSpec::PointCloud(p)) => Extent::of([&p.front, &p.back][face as usize].points_mm.iter().copied()),
            (Shape::Revolved(part), _) => {
                Extent::of(places(part.region()).filter_map(|at| Some(at.extend(part.jet_over(at.x, at.y)?.value))))
            }
            (Shape::Stated(sheet) | Shape::Fitted(sheet), _) => {
                Extent::of(places(sheet.domain()).map(|at| at.extend(sheet.sag().value(at.x, at.y))))
            }
        };
        Some(Given { key: keys[face as usize], extent, shape })
    };
    Face::ALL.into_iter().filter_map(surface).collect()
}

/// Places inside a region, its border included.
fn places(region: Rect) -> impl Iterator<Item = DVec2> {
    let share = |k: usize| k as f64 / (PLACES - 1) as f64;
    (0..PLACES * PLACES).map(move |k| region.min + region.size() * DVec2::new(share(k % PLACES), share(k / PLACES)))
}

/// Every doubt about the surfaces of a scene's prism, the gravest first: what is seen, and what to write instead.
pub(super) fn of(scene: &Scene, system: &System) -> Vec<String> {
    let given = given(&scene.prism, system.designed.as_deref());
    let Some(body) = scene.prism.body() else { return Vec::new() };
    let pinhole = body.world_from_prism.inverse().point(scene.camera.position_mm);
    let mut doubts = Vec::new();
    for surface in &given {
        doubts.extend(size(surface));
        doubts.extend(behind_camera(surface, pinhole));
        doubts.extend(left_half(surface));
        doubts.extend(sheets(surface, &scene.prism));
        doubts.extend(leaning(surface, &scene.prism));
    }
    if let [front, back] = &given[..] {
        doubts.extend(order(front, back));
    }
    if !is_own_halves(&scene.prism) {
        doubts.extend(given.iter().filter_map(both_halves));
    }
    doubts.dedup();
    doubts
}

/// Whether the surfaces are parts of a closed body, which may reach into both halves.
fn is_own_halves(prism: &PrismSpec) -> bool {
    matches!(prism, PrismSpec::Mesh(MeshSpec { told: Some(_), .. }))
}

/// Where the surfaces are and where the rays of the picture are: what to say of a prism that all rays miss.
pub(super) fn where_it_is(scene: &Scene, system: &System) -> String {
    let given = given(&scene.prism, system.designed.as_deref());
    let Some(front) = given.first() else {
        return "move the prism into the way of the rays: `prism.position_mm`, `prism.tilt_deg`".to_owned();
    };
    let body = scene.prism.body().map(|body| body.world_from_prism.inverse());
    let middle = 0.5 * (front.extent.min.z + front.extent.max.z);
    let at = |px: DVec2| {
        let ray = body.map_or(system.camera.ray(px), |prism_from_world| system.camera.ray(px).moved(&prism_from_world));
        ray.at((middle - ray.origin.z) / ray.direction.z)
    };
    let size = DVec2::from_array(system.camera.size_px().map(|n| n as f64));
    let needed = Extent::of([DVec2::ZERO, size, DVec2::new(size.x, 0.0), DVec2::new(0.0, size.y)].into_iter().map(at));
    format!(
        "the front is at {}, and the rays of the picture are at x {} to {}, y {} to {} there: check `unit`, `flip` and \
         `offset_mm` of the surfaces, and `prism.position_mm`",
        front.extent.words(),
        short(needed.min.x),
        short(needed.max.x),
        short(needed.min.y),
        short(needed.max.y)
    )
}

fn size(surface: &Given) -> Option<String> {
    let width = (surface.extent.max - surface.extent.min).truncate().max_element();
    let (key, words) = (surface.key, surface.extent.words());
    if width < TOO_SMALL_MM {
        Some(format!(
            "`{key}` is {} mm wide ({words}): write `unit = \"m\"` beside its file if its numbers are in m, or \"in\"",
            short(width)
        ))
    } else if width > TOO_LARGE_MM {
        Some(format!(
            "`{key}` is {} mm wide ({words}): write `unit = \"um\"` beside its file if its numbers are in um",
            short(width)
        ))
    } else {
        None
    }
}

fn behind_camera(surface: &Given, pinhole: DVec3) -> Option<String> {
    let Extent { min, max } = surface.extent;
    let (key, words) = (surface.key, surface.extent.words());
    if max.z <= pinhole.z {
        return Some(format!(
            "`{key}` lies behind the pinhole at z {} mm ({words}): write `flip = \"z\"` (or take it out) if its z grows towards the \
             camera, or `offset_mm = [0, 0, D]` with its distance D from the camera",
            short(pinhole.z)
        ));
    }
    (min.z <= pinhole.z).then(|| {
        format!(
            "`{key}` lies around the pinhole at z {} mm ({words}): write `offset_mm = [0, 0, D]` with the distance D of its \
             own origin from the camera",
            short(pinhole.z)
        )
    })
}

fn left_half(surface: &Given) -> Option<String> {
    let Extent { min, max } = surface.extent;
    (max.x <= OTHER_HALF * -min.x).then(|| {
        format!(
            "`{}` is the left half (x {} to {} mm), and the right one is asked for: write `flip = \"x\"` beside its file, or \
             take it out",
            surface.key,
            short(min.x),
            short(max.x)
        )
    })
}

fn both_halves(surface: &Given) -> Option<String> {
    let Extent { min, max } = surface.extent;
    let reach = (-min.x / max.x).min(-max.x / min.x);
    // A smooth surface may reach beyond the ridge for the rays of a pupil, and one that is stated knows no bounds.
    let allowed = match surface.shape {
        Shape::Stated(_) | Shape::Revolved(_) => return None,
        Shape::Mesh(..) if reach > OTHER_HALF && surface.has_ridge() => OTHER_HALF,
        Shape::Fitted(_) | Shape::Mesh(..) => MOST_OF_OTHER_HALF,
    };
    if reach.is_nan() || reach <= allowed {
        return None;
    }
    // What is its own mirror image, as a plane base is, may well be given whole.
    let limit = 1e-6 * (max - min).max_element();
    let differs = |at: DVec2| {
        let other = surface.height(DVec2::new(-at.x, at.y));
        surface.height(at).zip(other).is_some_and(|(a, b)| (a - b).abs() > limit)
    };
    if surface.key == "prism.back" && !places(surface.region()).any(differs) {
        return None;
    }
    Some(format!(
        "`{}` reaches from x {} to {} mm, over both halves: only the right half is used, and its mirror image; leave out \
         what has x below 0",
        surface.key,
        short(min.x),
        short(max.x)
    ))
}

fn sheets(surface: &Given, prism: &PrismSpec) -> Option<String> {
    let Shape::Mesh(own, mesh) = surface.shape else { return None };
    let limit = 1e-6 * (surface.extent.max - surface.extent.min).max_element();
    let spans: Vec<(DVec2, [f64; 2])> = places(surface.region())
        .filter_map(|at| Some((at, [surface.met(mesh, at, DVec3::Z)?, surface.met(mesh, at, -DVec3::Z)?])))
        .collect();
    let double: Vec<_> = spans.iter().filter(|(_, [low, high])| high - low > limit).collect();
    // A fold seen at its rim only is no sheet.
    if 10 * double.len() <= spans.len() || matches!(prism, PrismSpec::Mesh(MeshSpec { told: Some(_), .. })) {
        return None;
    }
    let (at, [low, high]) = double[double.len() / 2];
    let place = format!("z {} and {} mm over ({}, {})", short(*low), short(*high), short(at.x), short(at.y));
    Some(if is_closed(&own.points_mm, &own.triangles) {
        format!("`{}` is a closed body ({place}): write `body = \"...\"` in place of `front` and `back`", surface.key)
    } else {
        format!("`{}` has two sheets over one (x, y) ({place}): give each surface in a file of its own", surface.key)
    })
}

/// Triangles whose smooth normals lean away from them: a facet that was taken for a part of a curved surface, or one that is
/// too coarse.
fn leaning(surface: &Given, prism: &PrismSpec) -> Option<String> {
    let (Shape::Mesh(own, _), PrismSpec::Mesh(MeshSpec { normals: Normals::Smooth, .. })) = (&surface.shape, prism)
    else {
        return None;
    };
    let corners = |t: &[u32; 3]| t.map(|k| own.points_mm[k as usize]);
    let upward = |t: &[u32; 3]| {
        let [a, b, c] = corners(t);
        let normal = (b - a).cross(c - a);
        if normal.z < 0.0 { -normal } else { normal }
    };
    let lean = |t: &[u32; 3]| {
        let normal = upward(t);
        let [a, b, c] = corners(t);
        let leans = t.map(|k| own.point_normals[k as usize].angle_between(normal));
        (leans.into_iter().fold(0.0, f64::max).to_degrees(), (a + b + c) / 3.0)
    };

    // Leave out those that surely lean less, by the cosine, which needs no arc.
    let cosine = libm::cos(LARGEST_LEAN_DEG.to_radians());
    let least_square = cosine * cosine * (1.0 + 1e-6);
    let may_lean = |t: &&[u32; 3]| {
        let normal = upward(t);
        t.iter().map(|k| own.point_normals[*k as usize]).any(|at_corner| {
            let along = at_corner.dot(normal);
            let upright = along * along >= least_square * at_corner.length_squared() * normal.length_squared();
            along <= 0.0 || !upright
        })
    };
    let (lean_deg, at) = own.triangles.iter().filter(may_lean).map(lean).max_by(|a, b| a.0.total_cmp(&b.0))?;
    (lean_deg > LARGEST_LEAN_DEG).then(|| {
        format!(
            "the normals by which `{}` refracts lean up to {} deg from its triangles, near ({}, {}, {}) mm: write \
             `normals = \"flat\"` if its faces are planes, or export it with finer triangles",
            surface.key,
            short(lean_deg),
            short(at.x),
            short(at.y),
            short(at.z)
        )
    })
}

fn order(front: &Given, back: &Given) -> Option<String> {
    let [a, b] = [front.region(), back.region()];
    let common = Rect { min: a.min.max(b.min).max(DVec2::new(0.0, f64::NEG_INFINITY)), max: a.max.min(b.max) };
    let gaps: Vec<f64> = if common.size().min_element() > 0.0 {
        places(common).filter_map(|at| Some(back.height(at)? - front.height(at)?)).collect()
    } else {
        Vec::new()
    };
    // Surfaces that are nowhere over one another are compared as a whole.
    let whole = 0.5 * (back.extent.min.z + back.extent.max.z - front.extent.min.z - front.extent.max.z);
    let gaps = if gaps.is_empty() { vec![whole] } else { gaps };
    let behind = gaps.iter().filter(|gap| **gap < 0.0).count();
    let least = gaps.iter().copied().fold(f64::INFINITY, f64::min);
    if behind == gaps.len() {
        let deepest = short(-least);
        Some(format!("`prism.front` lies behind `prism.back` by up to {deepest} mm: give the two the other way round"))
    } else if behind > 0 {
        Some(format!(
            "`prism.front` and `prism.back` cross: at {} of {} places the front lies behind the back, by up to {} mm; move \
             them apart with `offset_mm`",
            behind,
            gaps.len(),
            short(-least)
        ))
    } else {
        None
    }
}
