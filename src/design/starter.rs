//! A scene to begin with, as text with comments: from a sensor, a lens, a prism and a distance.

use super::angle::facet_angle_rad;
use crate::error::Error;
use std::fmt::Write;

/// Squares of the board along the width of the picture, about.
const SQUARES_ACROSS: f64 = 30.0;
/// Glass that is left at the edge of a facet, as a share of the height of the facet's wedge, and at least, in mm.
const EDGE_GLASS: [f64; 2] = [0.25, 4.0];

/// What the prism of a scene to begin with is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum StarterPrism {
    /// Designed for exactly horizontal epipolar lines.
    Exact,
    /// The design paper's.
    Freeform,
    /// Two flat facets before a flat back.
    Flat,
    /// No glass: a plain camera.
    None,
}

/// What a scene to begin with is made from.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct StarterScene {
    /// Its name.
    pub name: String,
    /// Columns and rows of the sensor.
    pub size_px: [usize; 2],
    /// Pixel pitch, in um.
    pub pitch_um: f64,
    /// Focal length of the lens, in mm.
    pub focal_mm: f64,
    /// Distance of the board from the camera, in mm.
    pub distance_mm: f64,
    /// Distance of the ridge from the camera, in mm.
    pub ridge_mm: f64,
    /// Refractive index of the glass.
    pub index: f64,
    /// The prism.
    pub prism: StarterPrism,
}

impl StarterScene {
    /// The text of the scene. The glass is as thick as its facets ask for, and the squares of the board are of a round size, with
    /// enough of them to fill both halves at twice the distance.
    ///
    /// # Errors
    /// As [`facet_angle_rad`]: a lens too wide for glass of that index.
    pub(crate) fn text(&self) -> Result<String, Error> {
        let [width_mm, height_mm] = self.size_px.map(|n| n as f64 * self.pitch_um * 1e-3);
        let depth_far = 2.0 * self.distance_mm;

        // The camera.
        let mut text = format!(
            "# A scene to begin with: change what differs, and ask `biprism check` what it holds. Every key is told in docs/scene.md.\n\
             name = {:?}\n\n[camera]\nfocal_length_mm = {:?}\nwidth_px = {}\nheight_px = {}\npixel_pitch_um = {:?}\n\
             # A lens as it was measured: calibration = \"camera.yml\" of OpenCV in place of focal_length_mm.\n",
            self.name, self.focal_mm, self.size_px[0], self.size_px[1], self.pitch_um
        );

        // The prism, and the nearest depth behind it.
        let thickness_mm = self.glass_mm(width_mm)?;
        let behind_mm = thickness_mm.map_or(0.0, |thickness_mm| self.ridge_mm + thickness_mm);
        if behind_mm >= self.distance_mm {
            let rule =
                format!("the board at {} mm stands in the prism, which ends at {behind_mm} mm", self.distance_mm);
            return Err(Error::new("--distance-mm", rule, "move the board away, or the ridge nearer with --ridge-mm"));
        }
        let halfway_mm = 0.5 * (behind_mm + self.distance_mm);
        let depth_near = if 0.5 * self.distance_mm > 1.2 * behind_mm { 0.5 * self.distance_mm } else { halfway_mm };
        text += &self.prism_text(width_mm, thickness_mm)?;

        // The board.
        let square_mm = round_length(self.distance_mm * width_mm / self.focal_mm / SQUARES_ACROSS);
        let seen_mm = depth_far / self.focal_mm * (0.5 * width_mm).max(height_mm);
        let squares = 2 * libm::ceil(0.6 * seen_mm / square_mm) as usize + 1;
        let _ = write!(
            text,
            "\n# An odd number of squares, so that the picture is its own mirror image; enough to fill both halves at every depth.\n\
             [board]\ncolumns = {squares}\nrows = {squares}\nsquare_mm = {square_mm:?}\n\
             position_mm = [0.0, 0.0, {:?}]\n\n\
             # Pinholes and epipolar lines are judged over boards at these depths.\n[analysis]\ndepths_mm = [{depth_near:?}, {:?}, \
             {depth_far:?}]\n\n\
             # An effect is there when it has a table, and costs nothing without. A lens with a real aperture, for one:\n\
             # [effect.thin_lens]\n# f_number = 8.0\n# focus_mm = {:?}\n",
            self.distance_mm, self.distance_mm, self.distance_mm
        );
        Ok(text)
    }

    /// The thickness of the glass behind the ridge, in mm; `None` without glass.
    fn glass_mm(&self, width_mm: f64) -> Result<Option<f64>, Error> {
        if self.prism == StarterPrism::None {
            return Ok(None);
        }
        // The wedge of a facet stands over half the picture's field at the ridge.
        let wedge_mm = self.ridge_mm * 0.5 * width_mm / self.focal_mm * libm::tan(self.facet_rad(width_mm)?);
        Ok(Some(round_up(wedge_mm + (EDGE_GLASS[0] * wedge_mm).max(EDGE_GLASS[1]))))
    }

    /// The angle of a facet that leaves the two views parallel.
    fn facet_rad(&self, width_mm: f64) -> Result<f64, Error> {
        facet_angle_rad(self.index, libm::atan(0.25 * width_mm / self.focal_mm))
    }

    fn prism_text(&self, width_mm: f64, thickness_mm: Option<f64>) -> Result<String, Error> {
        let Some(thickness_mm) = thickness_mm else { return Ok("\n[prism]\nkind = \"none\"\n".to_owned()) };
        let kind = match self.prism {
            StarterPrism::Exact | StarterPrism::Freeform => "freeform",
            StarterPrism::Flat | StarterPrism::None => "flat",
        };
        let facet_rad = self.facet_rad(width_mm)?;
        let mut text = format!(
            "\n# The ridge faces the camera. The baseline grows with its distance, and so does the glass.\n[prism]\nkind = \"{kind}\"\n\
             index = {:?}\nridge_distance_mm = {:?}\nthickness_mm = {thickness_mm:?}\n\
             # facet_angle_deg is left out: {:.4} deg leave the two views parallel.\n",
            self.index,
            self.ridge_mm,
            facet_rad.to_degrees()
        );
        text += match self.prism {
            StarterPrism::Exact => {
                "\n# Rows that are epipolar lines at every depth, with one smooth rear surface for both halves.\n[prism.design]\n\
                 objective = \"epipolar\"\nrear = \"even\"\ndegree = 7\n"
            }
            StarterPrism::Freeform => "\n# As in the design paper.\n[prism.design]\norder = \"x-then-y\"\ndegree = 5\n",
            StarterPrism::Flat | StarterPrism::None => "",
        };
        Ok(text)
    }
}

/// The nearest of 1, 2 and 5 times a power of ten, by ratio.
fn round_length(value: f64) -> f64 {
    let power = libm::pow(10.0, libm::floor(libm::log10(value)));
    let off = |step: &&f64| libm::fabs(libm::log(*step * power / value));
    let step = [1.0, 2.0, 5.0, 10.0].iter().min_by(|a, b| off(a).total_cmp(&off(b))).copied().unwrap_or(1.0);
    tidy(step * power)
}

/// The next two-digit number above.
fn round_up(value: f64) -> f64 {
    let power = libm::pow(10.0, libm::floor(libm::log10(value)) - 1.0);
    tidy(libm::ceil(value / power) * power)
}

/// Without the rounding of powers of ten.
fn tidy(value: f64) -> f64 {
    format!("{value:.6e}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene;

    #[test]
    fn every_kind_is_a_scene_that_can_be_read() {
        for prism in [StarterPrism::Exact, StarterPrism::Freeform, StarterPrism::Flat, StarterPrism::None] {
            let starter = StarterScene {
                name: "mine".to_owned(),
                size_px: [1280, 960],
                pitch_um: 3.75,
                focal_mm: 16.0,
                distance_mm: 600.0,
                ridge_mm: 50.0,
                index: 1.5168,
                prism,
            };
            let text = starter.text().unwrap();
            let scene = scene::parse(&text, "starter", None).unwrap_or_else(|problem| panic!("{problem}"));
            assert_eq!([scene.camera.width_px, scene.camera.height_px], [1280, 960]);
            // 600 mm x 4.8 mm / 16 mm are 180 mm across: 30 squares of 5 mm are nearest among round sizes.
            assert_eq!(scene.board.square_mm, 5.0);
            assert!(scene.board.columns % 2 == 1 && scene.board.columns as f64 * 5.0 > 1.1 * 1200.0 * 3.6 / 16.0);
        }
    }

    #[test]
    fn lengths_are_rounded_by_ratio() {
        assert_eq!([0.9, 3.0, 3.4, 7.5, 140.0].map(round_length), [1.0, 2.0, 5.0, 10.0, 100.0]);
        assert_eq!([6.61, 0.1234, 99.1].map(round_up), [6.7, 0.13, 100.0]);
    }

    #[test]
    fn a_lens_too_wide_for_the_glass_is_refused() {
        let starter = StarterScene {
            name: "wide".to_owned(),
            size_px: [4000, 3000],
            pitch_um: 10.0,
            focal_mm: 4.0,
            distance_mm: 1000.0,
            ridge_mm: 80.0,
            index: 1.5,
            prism: StarterPrism::Flat,
        };
        assert!(starter.text().is_err());
    }
}
