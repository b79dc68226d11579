//! Surfaces from files: read, brought to mm and to the prism's frame, and, of a closed body, parted into front and back.

use super::document::Document;
use super::model::{CloudSpec, GlassSpec, MeshSpec};
use super::surface_keys::*;
use crate::error::Error;
use crate::geom::Pose;
use crate::io::mesh::{RawMesh, read_mesh, within_reach};
use crate::io::point_cloud::read_points;
use crate::surface::closed_body::{Sheets, sheets};
use crate::surface::face::Face;
use crate::surface::mesh::{Normals, Triangles};
use glam::DVec3;
use std::path::{Path, PathBuf};

/// From the numbers of a file to mm in the prism's frame.
struct Placement {
    /// mm a unit, with the sign of each axis.
    scale: DVec3,
    offset_mm: DVec3,
    pose: Pose,
}

impl Placement {
    fn new(file: &PlacementFile) -> Self {
        let unit_mm = match file.unit {
            UnitFile::Mm => 1.0,
            UnitFile::Um => 1e-3,
            UnitFile::M => 1e3,
            UnitFile::In => 25.4,
        };
        let axes = match &file.flip {
            None => &[][..],
            Some(FlipFile::One(axis)) => std::slice::from_ref(axis),
            Some(FlipFile::Several(axes)) => axes,
        };
        let sign = |axis: AxisFile| if axes.contains(&axis) { -unit_mm } else { unit_mm };
        Self {
            scale: DVec3::new(sign(AxisFile::X), sign(AxisFile::Y), sign(AxisFile::Z)),
            offset_mm: DVec3::from_array(file.offset_mm),
            pose: Pose::new(
                DVec3::from_array(file.pose.position_mm),
                DVec3::from_array(file.pose.tilt_deg.map(f64::to_radians)),
            ),
        }
    }

    fn point(&self, p: DVec3) -> DVec3 {
        let placed = p * self.scale + self.offset_mm;
        // No rounding enters where nothing is moved.
        if self.pose.is_identity() { placed } else { self.pose.point(placed) }
    }

    /// A unit normal, towards +z again.
    fn normal(&self, n: DVec3) -> DVec3 {
        let turned = self.pose.vector(n * self.scale.signum());
        if turned.z < 0.0 { -turned } else { turned }
    }

    fn mesh(&self, mut mesh: RawMesh) -> RawMesh {
        mesh.points.iter_mut().for_each(|p| *p = self.point(*p));
        mesh.normals.iter_mut().flatten().for_each(|n| *n = self.normal(*n));
        mesh
    }
}

/// The points of one surface of a prism.
pub(super) fn cloud(
    document: &Document,
    path: &str,
    file: &CloudFile,
    folder: Option<&Path>,
    surface: Face,
) -> Result<CloudSpec, Error> {
    let placement = Placement::new(&file.placement);
    let mut points_mm = read_points(&find(document, &format!("{path}.file"), &file.file, folder)?, surface)?;
    points_mm.iter_mut().for_each(|p| *p = placement.point(*p));
    Ok(CloudSpec {
        points_mm,
        degree: file.degree,
        symmetric: file.symmetric,
        max_residual_mm: file.max_residual_mm,
        file: file.file.clone(),
    })
}

/// The triangles of a prism: those of front and back, or of a closed body.
pub(super) fn mesh(
    document: &Document,
    body: GlassSpec,
    file: &MeshPrismFile,
    folder: Option<&Path>,
) -> Result<MeshSpec, Error> {
    let normals = match file.normals {
        NormalsFile::Smooth => Normals::Smooth,
        NormalsFile::Flat => Normals::Flat,
    };
    let missing = |key: &str, help: &str| document.fault("prism", format!("`prism.{key}` is missing"), help);
    let help = "add a file to `[prism]`: `front` towards the camera and `back` towards the board, or `body` for both";
    match (&file.solid, &file.front, &file.back) {
        (None, Some(front), Some(back)) => Ok(MeshSpec {
            body,
            front: surface(document, "prism.front", front, folder)?,
            back: surface(document, "prism.back", back, folder)?,
            normals,
            left: None,
            told: None,
        }),
        (None, None, _) => Err(missing("front", help)),
        (None, Some(_), None) => Err(missing("back", help)),
        (Some(solid), None, None) => closed_body(document, body, solid, normals, folder),
        (Some(_), ..) => {
            let key = if file.front.is_some() { "prism.front" } else { "prism.back" };
            let rule = format!("`{key}` stands beside `prism.body`, which gives front and back");
            Err(document.fault(key, rule, "keep `body` alone, or `front` and `back`"))
        }
    }
}

/// The key, the file and the triangles that it names, in the prism's frame.
fn raw(document: &Document, key: &str, file: &MeshFile, folder: Option<&Path>) -> Result<(String, RawMesh), Error> {
    let (key, name, placement) = match file {
        MeshFile::Name(name) => (key.to_owned(), name, Placement::new(&PlacementFile::default())),
        MeshFile::Placed(placed) => (format!("{key}.file"), &placed.file, Placement::new(&placed.placement)),
    };
    let found = find(document, &key, name, folder)?;
    Ok((found.display().to_string(), placement.mesh(read_mesh(&found)?)))
}

fn surface(document: &Document, key: &str, file: &MeshFile, folder: Option<&Path>) -> Result<Triangles, Error> {
    let (name, mesh) = raw(document, key, file, folder)?;
    mesh.surface(&name)
}

fn closed_body(
    document: &Document,
    body: GlassSpec,
    file: &MeshFile,
    normals: Normals,
    folder: Option<&Path>,
) -> Result<MeshSpec, Error> {
    let (name, mesh) = raw(document, "prism.body", file, folder)?;
    within_reach(&name, &mesh.points)?;
    let parted = sheets(&mesh.points, &mesh.triangles)
        .map_err(|(rule, help)| document.fault("prism.body", format!("`prism.body` ({name}): {rule}"), help))?;
    let told = Some(told(&parted));
    let Sheets { right: [front, back], left, .. } = parted;
    Ok(MeshSpec { body, front, back, normals, left, told })
}

/// What was made of a closed body, in words.
fn told(Sheets { left, counts, heights_mm, .. }: &Sheets) -> String {
    let [front, back] = heights_mm.map(|[low, high]| format!("z {low:.4} to {high:.4} mm"));
    let halves = match left {
        Some(_) => "it spans both halves, which are cut at x = 0 and used each as it is",
        None => "it is the right half, and the left one is its mirror image",
    };
    format!(
        "`prism.body` is a closed body: its lower sheet ({} triangles, {front}) is the front, its upper one ({}, {back}) the \
         back, and {} triangles of side walls are left aside; {halves}",
        counts[0], counts[1], counts[2]
    )
}

/// The path of a `file` that the key at `path` names, relative to the scene's folder.
pub(super) fn find(document: &Document, path: &str, file: &str, folder: Option<&Path>) -> Result<PathBuf, Error> {
    let problem = |rule, help| Err(document.fault(path, rule, help));
    let Some(folder) = folder else {
        let rule = format!("`{path}` is {file:?}, and a scene without a folder can name no file");
        return problem(rule, "save the scene beside its files, and give its path");
    };
    let found = folder.join(file);
    if found.is_dir() {
        let rule = format!("`{path}` is {file:?}, and {} is a directory", found.display());
        return problem(rule, "give the path of a file, relative to the scene file");
    }
    if !found.is_file() {
        let rule = format!("`{path}` is {file:?}, and there is no file {}", found.display());
        return problem(rule, "give the file's path relative to the scene file");
    }
    Ok(found)
}
