//! Solids: watertight, of the right volume, and the same prism when they are read back.

use super::*;
use biprism::io::mesh::read_mesh;
use biprism::surface::face::Face;
use biprism::system::Side;
use glam::{DVec2, DVec3};
use std::collections::BTreeMap;
use std::fs;

/// Scenes of every kind of prism.
const KINDS: [&str; 4] = ["prism_flat", "prism_freeform", "prism_revolved", "prism_mesh"];

/// A body by its triangles, and what is known of every closed one.
struct Body {
    points: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
}

impl Body {
    fn read(path: &Path) -> Self {
        let mesh = read_mesh(path).unwrap_or_else(|problem| panic!("{problem}"));
        Self { points: mesh.points, triangles: mesh.triangles }
    }

    /// Every edge belongs to two triangles that run along it in opposite senses, Euler's characteristic is that of a sphere, and
    /// normals point outwards.
    fn is_watertight(&self) {
        let mut edges: BTreeMap<[u32; 2], usize> = BTreeMap::new();
        for &[a, b, c] in &self.triangles {
            for edge in [[a, b], [b, c], [c, a]] {
                *edges.entry(edge).or_default() += 1;
            }
        }
        assert!(edges.iter().all(|(&[a, b], n)| *n == 1 && edges.get(&[b, a]) == Some(&1)));
        let characteristic = self.points.len() as i64 - (edges.len() / 2) as i64 + self.triangles.len() as i64;
        assert_eq!(characteristic, 2);
        assert!(self.volume_mm3() > 0.0);
    }

    fn volume_mm3(&self) -> f64 {
        let first = self.points[0];
        let corner = |k: u32| self.points[k as usize] - first;
        self.triangles.iter().map(|&[a, b, c]| corner(a).dot(corner(b).cross(corner(c))) / 6.0).sum()
    }

    fn outline(&self) -> [DVec2; 2] {
        let at = self.points.iter().map(|p| p.truncate());
        at.fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[min, max], p| [min.min(p), max.max(p)])
    }
}

/// The volume between front and back over a rectangle, by Gauss's rule of 3 points in cells, each half by its own surfaces.
fn integral_mm3(system: &System, [min, max]: [DVec2; 2]) -> f64 {
    const CELLS: usize = 12;
    let nodes = [(-(0.6f64.sqrt()), 5.0 / 18.0), (0.0, 8.0 / 18.0), (0.6f64.sqrt(), 5.0 / 18.0)];
    let along = move |from: f64, to: f64| {
        (0..CELLS).flat_map(move |k| {
            let width = (to - from) / CELLS as f64;
            let middle = from + (k as f64 + 0.5) * width;
            nodes.into_iter().map(move |(x, w)| (middle + 0.5 * width * x, width * w))
        })
    };
    let prism = system.prism().expect("it has one");
    let thickness = |side: Side, x: f64, y: f64| {
        let [front, back] = Face::ALL.map(|face| prism.surface(side, face).continued_mm(x, y).expect("it is there"));
        back - front
    };
    let half = |side: Side, from: f64, to: f64| -> f64 {
        let columns = along(from, to);
        columns.map(|(x, w)| w * along(min.y, max.y).map(|(y, v)| v * thickness(side, x, y)).sum::<f64>()).sum()
    };
    half(Side::Left, min.x, 0.0) + half(Side::Right, 0.0, max.x)
}

#[test]
fn bodies_of_every_kind_are_watertight_and_of_the_right_volume() {
    let folder = tempfile::tempdir().expect("a folder");
    for name in KINDS {
        let found = exported(name, "ply", folder.path(), &["--tolerance-mm", "1e-3"]);
        let figures = &found["files"][0];
        let body = Body::read(&folder.path().join("prism.ply"));
        body.is_watertight();
        assert_eq!(
            [number(&figures["points"]), number(&figures["triangles"])],
            [body.points.len() as f64, body.triangles.len() as f64]
        );
        let (chord, volume) = (number(&figures["chord_mm"]), number(&figures["volume_mm3"]));
        assert!(chord <= 1e-3 && (volume / body.volume_mm3() - 1.0).abs() < 1e-12, "{name}: {chord} {volume}");

        // Two sheets that stray by no more than their chords, over the area; rounding of 80 mm where they do not.
        let outline = body.outline();
        let area = (outline[1] - outline[0]).element_product();
        let integral = integral_mm3(&built(&case(name)), outline);
        let most = area * (2.2 * chord + 1e-12);
        println!("{name}: {volume} mm^3 for {integral}, at most {most} apart");
        assert!((volume - integral).abs() < most, "{name}: {volume} {integral}");
    }
}

/// No place of a triangle is farther from the surface than is told: looked for at many more places than the command looks at.
#[test]
fn chords_are_what_is_told() {
    let folder = tempfile::tempdir().expect("a folder");
    for name in ["prism_freeform", "prism_revolved"] {
        let found = exported(name, "ply", folder.path(), &["--tolerance-mm", "3e-3"]);
        let told = number(&found["files"][0]["chord_mm"]);
        let body = Body::read(&folder.path().join("prism.ply"));
        let system = built(&case(name));
        let prism = system.prism().expect("it has one");
        let mut most = 0.0f64;
        for triangle in &body.triangles {
            let [a, b, c] = triangle.map(|k| body.points[k as usize]);
            let normal = (b - a).cross(c - a);
            // Walls stand upright.
            if normal.z == 0.0 {
                continue;
            }
            let face = if normal.z > 0.0 { Face::Back } else { Face::Front };
            for (i, j) in (0..=8).flat_map(|i| (0..=8 - i).map(move |j| (i, j))) {
                let p = a + (b - a) * (f64::from(i) / 8.0) + (c - a) * (f64::from(j) / 8.0);
                let side = if (a + b + c).x < 0.0 { Side::Left } else { Side::Right };
                let z = prism.surface(side, face).continued_mm(p.x, p.y).expect("it is there");
                most = most.max((z - p.z).abs());
            }
        }
        println!("{name}: {most:e} mm, told {told:e}");
        // A tenth more than is told: see the definition.
        assert!(most < 1.1 * told && most > 0.9 * told, "{name}: {most:e} {told:e}");
    }
}

/// The three formats hold one body: PLY and OBJ the very numbers, STL their roundings.
#[test]
fn formats_hold_the_same_body() {
    let folder = tempfile::tempdir().expect("a folder");
    let read = |format: &str| {
        exported("prism_freeform", format, folder.path(), &["--tolerance-mm", "1e-2"]);
        Body::read(&folder.path().join(format!("prism.{format}")))
    };
    let [ply, obj, stl] = ["ply", "obj", "stl"].map(read);
    assert_eq!((&ply.points, &ply.triangles), (&obj.points, &obj.triangles));
    stl.is_watertight();
    assert_eq!(stl.triangles.len(), ply.triangles.len());
    for (own, rounded) in ply.triangles.iter().zip(&stl.triangles) {
        for (a, b) in own.iter().zip(rounded) {
            // Half the last bit of an f32 at 80 mm, and as much again for corners at one place.
            assert!(ply.points[*a as usize].distance(stl.points[*b as usize]) < 1e-5);
        }
    }
}

/// Read back as a body, the prism is the same within what its cells leave: normals between corners are off by h^2/8 of their second
/// derivatives, some 1e-4/mm^2 of these surfaces, h is 0.3 mm for chords of 1e-4 mm, and the board is 0.9 m behind.
#[test]
fn a_body_that_is_read_back_is_the_same_prism() {
    let folder = tempfile::tempdir().expect("a folder");
    for name in KINDS {
        let found = exported(name, "ply", folder.path(), &[]);
        let chord = number(&found["files"][0]["chord_mm"]);
        let prism = "[prism]\nkind = \"mesh\"\nindex = 1.48\nbody = \"prism.ply\"\n";
        let (own, again) = (built(&case(name)), built(&with_prism(name, prism, folder.path())));
        let mut worst = 0.0f64;
        for k in 0..300 {
            let even = |step: f64| (f64::from(k) * step).fract();
            let px = DVec2::new(320.0 * even(0.754_877_666), 180.0 * even(0.569_840_291));
            // Beside the ridge a crease of less than 1 deg is taken for smooth, and light crosses x = 0.
            if (px.x - 160.0).abs() < 16.0 {
                continue;
            }
            let (a, b) = (own.trace(px).expect("it passes"), again.trace(px).expect("it passes"));
            assert_eq!(a.side, b.side);
            worst = worst.max(a.board_mm.distance(b.board_mm));
        }
        let most = if chord > 1e-9 { 2.0 * 0.3 * 0.3 / 8.0 * 1e-4 * 0.48 * 900.0 * 2.0 } else { 1e-9 };
        println!("{name}: {worst:e} mm on the board, at most {most:e}");
        assert!(worst < most, "{name}: {worst:e} {most:e}");
    }
}

/// A prism of triangles, asymmetric and between two halves of its own, is cut like any other.
#[test]
fn a_body_of_triangles_is_cut_again() {
    let folder = tempfile::tempdir().expect("a folder");
    exported("prism_freeform", "ply", folder.path(), &["--tolerance-mm", "1e-2"]);
    let first = Body::read(&folder.path().join("prism.ply"));
    let text = fs::read_to_string(repository("scenes/cases/prism_freeform.toml")).expect("it is there");
    let (start, end) = (text.find("[prism]").expect("a prism"), text.find("[board]").expect("a board"));
    let prism = "[prism]\nkind = \"mesh\"\nindex = 1.48\nbody = \"prism.ply\"\n";
    fs::write(folder.path().join("again.toml"), format!("{}{prism}{}", &text[..start], &text[end..])).expect("written");
    let args = ["export", "again.toml", "--format", "obj", "--tolerance-mm", "2e-3", "--out", "again.obj", "--json"];
    let found = json(&biprism(folder.path(), &args));
    let again = Body::read(&folder.path().join("again.obj"));
    again.is_watertight();
    let [[low, high], [a, b]] = [first.outline(), again.outline()];
    assert!((a - low).abs().max((b - high).abs()).max_element() < 1e-6, "{a} {b}");
    let chord = number(&found["files"][0]["chord_mm"]);
    // The outline is smaller by 1e-9 of itself.
    let most = (high - low).element_product() * 2.2 * chord + 1e-8 * first.volume_mm3();
    assert!(chord <= 2e-3 && (again.volume_mm3() - first.volume_mm3()).abs() < most, "{chord}");
}

/// A file or a folder, as it is asked for.
#[test]
fn files_go_where_they_are_asked_for() {
    let folder = tempfile::tempdir().expect("a folder");
    exported("prism_flat", "obj", folder.path(), &[]);
    let path = repository("scenes/cases/prism_flat.toml").display().to_string();
    for out in ["deep/er/own.STL", "other"] {
        let found =
            json(&biprism(folder.path(), &["export", path.as_str(), "--format", "stl", "--out", out, "--json"]));
        let written = found["files"][0]["path"].as_str().expect("a path").to_owned();
        assert!(fs::metadata(folder.path().join(&written)).is_ok_and(|file| file.len() == 84 + 20 * 50), "{written}");
        assert!(written == out || written == "other/prism.stl", "{written}");
    }
    assert!(folder.path().join("prism.obj").is_file());
    for (format, name) in [("npy", "truth.npy"), ("cameras-yml", "cameras.yml")] {
        exported("prism_flat", format, folder.path(), &[]);
        assert!(folder.path().join(name).is_file());
    }
    let other = biprism(folder.path(), &["render", &path, "--out", "own.npy"]);
    assert!(other.status.success());
    assert_eq!(fs::read(folder.path().join("own.npy")).ok(), fs::read(folder.path().join("truth.npy")).ok());
    // The two pinholes are as far apart as the command says elsewhere.
    let yaml = fs::read_to_string(folder.path().join("cameras.yml")).expect("written");
    assert!(yaml.contains("M1: !!opencv-matrix") && yaml.contains("T_right") && yaml.contains("distance_mm"), "{yaml}");
}
