//! A designed prism as the text of a scene, which the scene parser reads like any other.

use crate::scene::{GlassSpec, PolynomialPatch, RevolvedPatch, RevolvedSpec};
use std::fmt::Write;

/// The tables `[prism]`, `[prism.law]` where it is stated, `[prism.front]` and `[prism.back]` of a scene file for a prism of
/// two polynomials, for the glass of `body` (its pose is left to the scene's author). Every number reads back as the same f64;
/// terms that are exactly 0 are left out.
pub fn scene_prism(front: &PolynomialPatch, back: &PolynomialPatch, body: &GlassSpec) -> String {
    head("polynomial", body) + &patch("prism.front", front) + &patch("prism.back", back)
}

/// The same tables for a prism of two surfaces of revolution.
pub(crate) fn scene_revolved(prism: &RevolvedSpec) -> String {
    let RevolvedSpec { body, front, back } = prism;
    head("revolved", body) + &revolved("prism.front", front) + &revolved("prism.back", back)
}

/// A surface as a file of sag over a grid, y up and z from the vertex.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct GridSagText {
    /// The file, beside the scene.
    pub file: String,
    /// Total degree of the polynomial that is fitted to it.
    pub degree: usize,
    /// z of the vertex in the prism's frame, in mm.
    pub vertex_mm: f64,
}

/// The same tables for a prism of two surfaces in such files.
pub(crate) fn scene_grid_sag(front: &GridSagText, back: &GridSagText, body: &GlassSpec) -> String {
    let cloud = |name: &str, GridSagText { file, degree, vertex_mm }: &GridSagText| {
        format!(
            "\n[prism.{name}]\nfile = {file:?}\ndegree = {degree}\nflip = \"y\"\noffset_mm = [0.0, 0.0, {vertex_mm:?}]\n"
        )
    };
    head("point_cloud", body) + &cloud("front", front) + &cloud("back", back)
}

fn head(kind: &str, body: &GlassSpec) -> String {
    let mut text =
        format!("[prism]\nkind = \"{kind}\"\nindex = {:?}\nouter_index = {:?}\n", body.index, body.outer_index);
    if let Some(glass) = body.glass {
        writeln!(text, "glass = {:?}\nwavelength_nm = {:?}", glass.name, body.wavelength_nm)
            .expect("writing to a string cannot fail");
    }
    if let Some(solid) = body.solid {
        writeln!(text, "solid = {solid}").expect("writing to a string cannot fail");
    }
    if let Some(law) = &body.law {
        let [f_x, f_y] = law.focal_mm;
        write!(text, "\n[prism.law]\nf_mm = [{f_x:?}, {f_y:?}]\n").expect("writing to a string cannot fail");
        for (key, value) in law.keys() {
            writeln!(text, "{key} = {value:?}").expect("writing to a string cannot fail");
        }
    }
    text
}

fn revolved(name: &str, patch: &RevolvedPatch) -> String {
    let RevolvedPatch { point_mm, axis, profile, azimuth_rad } = patch;
    let coefficients: Vec<String> = profile.coefficients().iter().map(|c| format!("  {c:?},\n")).collect();
    format!(
        "\n[{name}]\n# The distance from the axis in mm is the sum of c_k T_k(x), x from -1 to 1 over along_mm.\n\
         origin_mm = {:?}\naxis = {:?}\nalong_mm = {:?}\nazimuth_deg = {:?}\nprofile_mm = [\n{}]\n",
        point_mm.to_array(),
        axis.to_array(),
        profile.ends(),
        azimuth_rad.to_degrees(),
        coefficients.concat()
    )
}

fn patch(name: &str, patch: &PolynomialPatch) -> String {
    let ([x, y], [sx, sy]) = (patch.sag.centre(), patch.sag.scale());
    let (min, max) = (patch.domain.min, patch.domain.max);
    let mut text = format!(
        "\n[{name}]\n# z in mm = sum of c ((x - centre x)/scale x)^m ((y - centre y)/scale y)^n over the terms [m, n, c].\n\
         centre_mm = [{x:?}, {y:?}]\nscale_mm = [{sx:?}, {sy:?}]\ndomain_mm = [[{:?}, {:?}], [{:?}, {:?}]]\nterms = [\n",
        min.x, max.x, min.y, max.y
    );
    for (m, n, c) in patch.sag.terms().filter(|term| term.2 != 0.0) {
        writeln!(text, "  [{m}, {n}, {c:?}],").expect("writing to a string cannot fail");
    }
    text.push_str("]\n");
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Rect;
    use crate::num::curve::ChebyshevCurve;
    use crate::num::poly2::Poly2;
    use crate::scene::PrismSpec;
    use glam::{DVec2, DVec3};

    /// A patch whose numbers are awkward to print: thirds, tiny, huge, negative zero and whole ones.
    fn awkward(sign: f64) -> PolynomialPatch {
        let c = |m: usize, n: usize| match (m, n) {
            (0, 0) => sign / 3.0,
            (1, 0) => 1e-300,
            (2, 0) => -1.2345678901234567e17,
            (0, 2) => 2.0,
            _ => 0.0,
        };
        let domain = Rect { min: DVec2::new(-0.1, -7.0), max: DVec2::new(std::f64::consts::PI, 7.0) };
        PolynomialPatch { sag: Poly2::new(3, [6.0 + f64::EPSILON * 4.0, -0.0], [1.0 / 7.0, 5e-5], c), domain }
    }

    fn body() -> GlassSpec {
        GlassSpec::new(1.48, 1.0)
    }

    #[test]
    fn every_number_reads_back_as_it_was() {
        let (front, back) = (awkward(1.0), awkward(-1.0));
        let text = scene_prism(&front, &back, &body());
        let table: toml::Table = text.parse().unwrap();
        let prism = &table["prism"];
        assert_eq!(prism["kind"].as_str(), Some("polynomial"));
        assert_eq!((prism["index"].as_float(), prism["outer_index"].as_float()), (Some(1.48), Some(1.0)));
        for (name, patch) in [("front", front), ("back", back)] {
            let part = &prism[name];
            let pair = |v: &toml::Value| [0, 1].map(|i| v[i].as_float().unwrap().to_bits());
            assert_eq!(pair(&part["centre_mm"]), patch.sag.centre().map(f64::to_bits));
            assert_eq!(pair(&part["scale_mm"]), patch.sag.scale().map(f64::to_bits));
            assert_eq!(pair(&part["domain_mm"][0]), [patch.domain.min.x, patch.domain.max.x].map(f64::to_bits));
            assert_eq!(pair(&part["domain_mm"][1]), [patch.domain.min.y, patch.domain.max.y].map(f64::to_bits));
            let read: Vec<_> = part["terms"]
                .as_array()
                .unwrap()
                .iter()
                .map(|t| {
                    (t[0].as_integer().unwrap() as usize, t[1].as_integer().unwrap() as usize, t[2].as_float().unwrap())
                })
                .collect();
            assert_eq!(read, patch.sag.terms().filter(|t| t.2 != 0.0).collect::<Vec<_>>());
        }
    }

    #[test]
    fn surfaces_of_revolution_read_back_as_they_were() {
        let part = |z: f64| {
            let profile = ChebyshevCurve::new([-0.1, 12.0 + 1.0 / 3.0], vec![z, 1.0 / 7.0, -1e-300, 2.5e-13]);
            let axis = DVec3::new(1.0, 0.0, 0.1).normalize();
            RevolvedPatch { point_mm: DVec3::new(-0.0, 1e-5, 1.0 / 3.0), axis, profile, azimuth_rad: 0.1 }
        };
        let solid = Some(false);
        let spec = RevolvedSpec { body: GlassSpec { solid, ..body() }, front: part(79.0), back: part(87.5) };
        let text = format!(
            "name = \"t\"\n[camera]\nfocal_length_mm = 35\nwidth_px = 64\nheight_px = 36\npixel_pitch_um = 165\n{}\
             [board]\ncolumns = 9\nrows = 9\nsquare_mm = 20\nposition_mm = [0, 0, 1000]\n",
            scene_revolved(&spec)
        );
        let read = crate::scene::parse(&text, "t", None).unwrap_or_else(|problem| panic!("{problem}")).prism;
        let PrismSpec::Revolved(read) = read else { panic!("{read:?}") };
        // Degrees round.
        assert!((read.front.azimuth_rad - 0.1).abs() < 1e-16);
        let same = |read: &RevolvedPatch, own: &RevolvedPatch| {
            assert_eq!(*read, RevolvedPatch { azimuth_rad: read.azimuth_rad, ..own.clone() });
        };
        same(&read.front, &spec.front);
        same(&read.back, &spec.back);
        assert_eq!(read.body, spec.body);
    }
}
