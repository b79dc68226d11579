//! The feasibility check: a few rays of the field, traced through plane faces, tell the shapes that cannot take a
//! picture from those that merely take a hard one.

use super::limits::FACET_DEG;
use super::model::{BiprismSpec, CameraSpec, PolynomialSpec, PrismSpec, Scene};
use super::source::ValueSource;
use crate::effect::Telecentric;
use crate::error::Error;
use crate::geom::{Pose, Ray};
use crate::optics::snell::{refract, straightening_facet_rad};
use glam::{DVec2, DVec3};

/// Judge how camera, prism and board stand to each other. Returns the depths of the analysis; of those that nobody gave, only
/// the ones beyond the glass.
pub(super) fn check(source: &dyn ValueSource, scene: &Scene) -> Result<Vec<f64>, Error> {
    let camera = &FieldRays { camera: scene.camera, telecentric: scene.effects.lens.telecentric().copied() };
    looks_ahead(source, camera)?;
    let back = match &scene.prism {
        PrismSpec::Flat(prism) => Some(biprism(source, camera, prism, false)?),
        // A design is made for the plain pinhole.
        PrismSpec::Freeform(prism, _) => {
            let plain = FieldRays { camera: scene.camera.plain(), ..*camera };
            Some(biprism(source, &plain, prism, true)?)
        }
        PrismSpec::Polynomial(prism) => Some(polynomial(source, camera, prism)?),
        // Where a surface of revolution, of points or of triangles stands is for its rays to find.
        PrismSpec::None | PrismSpec::Revolved(_) | PrismSpec::PointCloud(_) | PrismSpec::Mesh(_) => None,
    };
    board(source, scene, back.as_ref())
}

/// Cells along each side of the picture of a calibrated camera, at whose corners it is judged.
const CELLS: usize = 16;

/// The chief rays of the field: the camera, and its telecentric lens where it has one.
#[derive(Clone, Copy)]
struct FieldRays {
    camera: CameraSpec,
    telecentric: Option<Telecentric>,
}

/// Where the glass ends: the plane z = `z_mm` of the prism's frame.
struct Back {
    prism_from_world: Pose,
    z_mm: f64,
}

/// The plane faces of a biprism, and the frame in which they stand.
struct Faces<'a> {
    prism: &'a BiprismSpec,
    prism_from_world: Pose,
    angle_rad: f64,
    slope: f64,
}

fn biprism(source: &dyn ValueSource, camera: &FieldRays, prism: &BiprismSpec, designed: bool) -> Result<Back, Error> {
    let prism_from_world = prism.body.world_from_prism.inverse();
    let angle_rad = match prism.facet_angle_rad {
        Some(angle) => angle,
        None => parallel_angle(source, camera, prism)?,
    };
    let faces = Faces { prism, prism_from_world, angle_rad, slope: libm::tan(angle_rad) };
    pinhole_is_in_front(source, camera, &faces)?;
    facets_end_before_base(source, camera, &faces)?;
    light_passes(source, camera, &faces, designed)?;
    Ok(Back { prism_from_world, z_mm: prism.ridge_distance_mm + prism.thickness_mm })
}

/// All that the camera sees lies before it along z, where prism and board are.
fn looks_ahead(source: &dyn ValueSource, camera: &FieldRays) -> Result<(), Error> {
    if camera.camera.calibrated().is_none() || field(camera, CELLS, CELLS).all(|ray| ray.direction.z > 0.0) {
        return Ok(());
    }
    let axis = camera.camera.axis().to_array().map(rounded);
    let rule = format!(
        "`camera.rotation_deg` turns the camera's axis to {axis:?}, and rays of its picture run away from the board, which is \
         seen along +z"
    );
    Err(source.refuse("camera.rotation_deg", rule, "give smaller angles, in deg, about the x, y and z axis"))
}

fn pinhole_is_in_front(source: &dyn ValueSource, camera: &FieldRays, faces: &Faces) -> Result<(), Error> {
    let distance = faces.prism.ridge_distance_mm;
    let pinhole = faces.prism_from_world.point(camera.camera.position_mm);
    if pinhole.z < distance + pinhole.x.abs() * faces.slope {
        return Ok(());
    }
    let rule = format!(
        "`prism.ridge_distance_mm` is {distance}, and the pinhole, at [{}, {}, {}] in the prism's frame, is not in \
         front of the facets",
        rounded(pinhole.x),
        rounded(pinhole.y),
        rounded(pinhole.z)
    );
    let help = "move the prism away from the camera: `prism.position_mm`, `prism.tilt_deg`, `prism.ridge_distance_mm`";
    Err(source.refuse("prism.ridge_distance_mm", rule, help))
}

/// The depth of a facet is a ratio of linear functions of the sensor's point, so it is greatest at a corner; of a picture that is
/// distorted it may be so elsewhere on the border.
fn facets_end_before_base(source: &dyn ValueSource, camera: &FieldRays, faces: &Faces) -> Result<(), Error> {
    let (distance, thickness) = (faces.prism.ridge_distance_mm, faces.prism.thickness_mm);
    let (base_z, degrees) = (distance + thickness, faces.angle_rad.to_degrees());
    let cells = if camera.camera.calibrated().is_some() { CELLS } else { 1 };
    for ray in field(camera, cells, cells) {
        let Some((hit, _)) = intersect(&ray.moved(&faces.prism_from_world), distance, faces.slope) else {
            let rule = format!(
                "`prism.facet_angle_deg` is {degrees:.4}, and the ray of a corner of the picture never meets the facet"
            );
            let help = "give a smaller facet angle or tilt, or a narrower field";
            return Err(source.refuse("prism.facet_angle_deg", rule, help));
        };
        if hit.z > base_z {
            let rule = format!(
                "`prism.thickness_mm` is {thickness}, and the facet crosses the base inside the picture: at a corner \
                 its z is {:.4} mm, and the base has {base_z:.4} mm",
                hit.z
            );
            let least = hit.z - distance;
            let help = format!("give a thickness above {least:.4}, or a facet angle smaller than {degrees:.4} deg");
            return Err(source.refuse("prism.thickness_mm", rule, &help));
        }
    }
    Ok(())
}

/// A design starts from the middle ray of each half image; a flat prism is worth a picture if any ray passes.
fn light_passes(source: &dyn ValueSource, camera: &FieldRays, faces: &Faces, designed: bool) -> Result<(), Error> {
    const RAYS: (usize, usize) = (16, 8);
    let body = &faces.prism.body;
    let passes = |ray: Ray| {
        let ray = ray.moved(&faces.prism_from_world);
        intersect(&ray, faces.prism.ridge_distance_mm, faces.slope)
            .and_then(|(_, normal)| refract(ray.direction, normal, body.outer_index / body.index))
            .map(|out| out.direction)
            .filter(|inside| inside.z > 0.0)
            .is_some_and(|inside| refract(inside, DVec3::Z, body.index / body.outer_index).is_some())
    };
    let whose = match designed {
        true if !half_centres(camera).all(passes) => "the middle ray of a half image is",
        false if !field(camera, RAYS.0, RAYS.1).any(passes) => "every ray of the picture is",
        _ => return Ok(()),
    };
    let rule = format!(
        "`prism.facet_angle_deg` is {:.4}, and {whose} totally reflected in glass of index {} in {}",
        faces.angle_rad.to_degrees(),
        body.index,
        body.outer_index
    );
    let help = "give a smaller facet angle or tilt, or a smaller index ratio";
    Err(source.refuse("prism.facet_angle_deg", rule, help))
}

/// alpha of the design paper's Eq. 5, corrected, for the direction delta of the middle of a half image.
fn parallel_angle(source: &dyn ValueSource, camera: &FieldRays, prism: &BiprismSpec) -> Result<f64, Error> {
    let angle = straightening_facet_rad(prism.body.index / prism.body.outer_index, camera.camera.half_centre_rad());
    if let Some(angle) = angle.filter(|angle| *angle < FACET_DEG.to_radians()) {
        return Ok(angle);
    }
    let rule = format!(
        "`prism.facet_angle_deg` is left out, and no facet of glass of index {} in {} leaves the two views parallel",
        prism.body.index, prism.body.outer_index
    );
    Err(source.refuse("prism.index", rule, "give `facet_angle_deg`, or another `index`"))
}

fn polynomial(source: &dyn ValueSource, camera: &FieldRays, prism: &PolynomialSpec) -> Result<Back, Error> {
    let middle = |domain: crate::geom::Rect| -> DVec2 { (domain.min + domain.max) / 2.0 };
    let prism_from_world = prism.body.world_from_prism.inverse();
    let (f, b) = (middle(prism.front.domain), middle(prism.back.domain));
    let (front_z, back_z) = (prism.front.sag.value(f.x, f.y), prism.back.sag.value(b.x, b.y));
    let pinhole = prism_from_world.point(camera.camera.position_mm);
    for (key, z) in [("front", front_z), ("back", back_z)] {
        if !z.is_finite() {
            let at = format!("prism.{key}");
            let rule = format!("`{at}.terms` give z = {z} in the middle of the domain, and a surface is finite");
            return Err(source.refuse(&format!("{at}.terms"), rule, "give smaller coefficients"));
        }
    }
    let (rule, help) = if pinhole.z >= front_z {
        (
            format!(
                "`prism.front` stands at z = {} in the middle of its domain, not in front of the pinhole at z = {}",
                rounded(front_z),
                rounded(pinhole.z)
            ),
            "raise its constant term [0, 0, c], or move the prism with `position_mm`",
        )
    } else if front_z >= back_z {
        (
            format!(
                "`prism.front` stands at z = {} and `prism.back` at {}: no glass is between them",
                rounded(front_z),
                rounded(back_z)
            ),
            "give the back a larger constant term [0, 0, c] than the front",
        )
    } else {
        return Ok(Back { prism_from_world, z_mm: back_z });
    };
    Err(source.refuse("prism.front.terms", rule, help))
}

/// Board and depths of the analysis lie in front of the camera and beyond the glass.
fn board(source: &dyn ValueSource, scene: &Scene, back: Option<&Back>) -> Result<Vec<f64>, Error> {
    let pinhole = scene.camera.position_mm;
    let judge_of = |key: &str, what: &str, point: DVec3| {
        let depth = point.z - pinhole.z;
        let glass = back.map(|b| (b.prism_from_world.point(point).z, b.z_mm));
        let fault = match glass {
            _ if depth <= 0.0 => {
                format!("at a depth of {} mm, and the camera sees only depths above 0", rounded(depth))
            }
            Some((z, end)) if z <= end => {
                format!("at z = {} mm of the prism's frame, and the glass ends at {}", rounded(z), rounded(end))
            }
            _ => return Ok(()),
        };
        let (at, left_out) = if source.gives(key) { (key, "") } else { ("prism", ", left out,") };
        let help = format!("move it away from the camera, beyond the prism: `{key}`");
        Err(source.refuse(at, format!("`{key}`{left_out} puts {what} {fault}"), &help))
    };
    let judge = |key: &str, point: DVec3| judge_of(key, "the board", point);

    // All of an object is seen through the prism.
    for (k, object) in scene.objects.iter().enumerate() {
        let plate = &object.plate;
        let half = 0.5 * object.size_mm() + plate.margin_mm;
        for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
            let corner = plate.world_from_board.point(DVec3::new(x * half.x, y * half.y, 0.0));
            judge_of(&format!("object[{k}].position_mm"), "a corner of the object", corner)?;
        }
    }
    judge("board.position_mm", scene.board.world_from_board.translation_mm)?;
    let at = |depth: f64| pinhole + DVec3::Z * depth;
    let depths = &scene.analysis.depths_mm;
    if !source.gives("analysis.depths_mm") {
        return Ok(depths.iter().copied().filter(|depth| judge("analysis.depths_mm", at(*depth)).is_ok()).collect());
    }
    for (i, depth) in depths.iter().enumerate() {
        judge(&format!("analysis.depths_mm[{i}]"), at(*depth))?;
    }
    Ok(depths.clone())
}

/// A number that was computed, to ten digits and no more than it has: what rounding left of it says nothing.
fn rounded(value: f64) -> f64 {
    format!("{value:.9e}").parse().unwrap_or(value)
}

/// The rays of a grid of `columns` x `rows` cells over the whole sensor, borders included, in the world.
fn field(camera: &FieldRays, columns: usize, rows: usize) -> impl Iterator<Item = Ray> {
    let camera = *camera;
    (0..=rows)
        .flat_map(move |j| (0..=columns).map(move |i| ray(&camera, i as f64 / columns as f64, j as f64 / rows as f64)))
}

/// The rays of the middles of the two half images.
fn half_centres(camera: &FieldRays) -> impl Iterator<Item = Ray> {
    let camera = *camera;
    [0.25, 0.75].into_iter().map(move |u| ray(&camera, u, 0.5))
}

/// The ray of the sensor's point (u, v), each from 0 to 1.
fn ray(&FieldRays { camera, telecentric }: &FieldRays, u: f64, v: f64) -> Ray {
    let px = DVec2::new(u * camera.width_px as f64, v * camera.height_px as f64);
    let origin = camera.position_mm;
    match telecentric {
        None => Ray { origin, direction: camera.direction(px) },
        Some(lens) => {
            let place = (px - camera.middle_px()) * camera.pitch_mm / lens.magnification;
            Ray { origin: origin + place.extend(0.0), direction: DVec3::Z }
        }
    }
}

/// Where a ray that starts in front of z = D + |x| slope first meets it, and the normal there (towards +z); `None`
/// when it never does.
fn intersect(ray: &Ray, distance: f64, slope: f64) -> Option<(DVec3, DVec3)> {
    let facet = |side: f64| {
        let normal = DVec3::new(-side * slope, 0.0, 1.0);
        let approach = normal.dot(ray.direction);
        (approach > 0.0).then(|| ((distance - normal.dot(ray.origin)) / approach, normal.normalize()))
    };
    // The facets are the farther of their two planes where they rise from the ridge, and the nearer where they fall.
    let (t, normal) = match (facet(1.0), facet(-1.0)) {
        (Some(a), Some(b)) if (a.0 > b.0) == (slope >= 0.0) => a,
        (Some(_), Some(b)) => b,
        (a, b) if slope < 0.0 => a.or(b)?,
        _ => return None,
    };
    let hit = ray.at(t);
    hit.is_finite().then_some((hit, normal))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::document::Document;

    #[test]
    fn ray_meets_the_facet_of_its_side_at_the_closed_form() {
        let distance = 78.0;
        for (t, slope) in
            [(-0.3, 0.15), (-1e-9, 0.15), (0.0, 0.15), (0.2, 0.15), (-0.3, -0.2), (1e-9, -0.2), (9.0, -3.0)]
        {
            let ray = Ray { origin: DVec3::ZERO, direction: DVec3::new(t, 0.1, 1.0).normalize() };
            let (hit, normal) = intersect(&ray, distance, slope).unwrap();
            let z = distance / (1.0 - f64::abs(t) * slope);
            // Two roundings of numbers near 80.
            assert!((hit - DVec3::new(t * z, 0.1 * z, z)).length() < 1e-13, "{t}: {hit}");
            assert!(normal.z > 0.0 && (normal.x * t * slope < 0.0 || t == 0.0));
        }
    }

    #[test]
    fn ray_that_flees_the_facet_never_meets_it() {
        let direction = DVec3::new(0.5, 0.0, 1.0).normalize();
        assert!(intersect(&Ray { origin: DVec3::ZERO, direction }, 78.0, 2.0).is_none());
        assert!(intersect(&Ray { origin: DVec3::ZERO, direction: -DVec3::Z }, 78.0, 0.0).is_none());
    }

    #[test]
    fn refraction_keeps_snell_and_the_plane_of_incidence() {
        let (incoming, normal) = (DVec3::new(0.3, -0.2, 1.0).normalize(), DVec3::new(-0.1, 0.4, 1.0).normalize());
        for normal in [normal, -normal] {
            let out = refract(incoming, normal, 1.0 / 1.48).unwrap().direction;
            assert!((out.length() - 1.0).abs() < 1e-15);
            assert!((incoming.cross(normal) - out.cross(normal) * 1.48).length() < 1e-15);
            assert!(out.dot(normal) * incoming.dot(normal) > 0.0);
        }
    }

    #[test]
    fn angle_left_out_is_that_of_the_paper() {
        let document = Document::parse(include_str!("../../scenes/paper.toml"), "paper").unwrap();
        let scene = super::super::check::scene(&document, document.values().unwrap(), None).unwrap();
        let PrismSpec::Freeform(prism, _) = &scene.prism else { panic!("the paper has a freeform prism") };
        let angle = parallel_angle(&document, &FieldRays { camera: scene.camera, telecentric: None }, prism).unwrap();
        // The paper's 8.85 deg, to the digits of the recomputation.
        assert!((angle.to_degrees() - 8.85428).abs() < 5e-6);
    }
}
