//! What each figure of a comparison means: its formula, what it is easily mistaken for, and where the definition comes from. The
//! page that is looked into and `docs/metrics.md` are made from this one table.

/// The meaning of one row of the table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MetricMeaning {
    /// The row's label in [`table::rows`](super::table::rows), without its indent.
    pub label: &'static str,
    /// Its key under a design of `report.json`.
    pub key: &'static str,
    /// How it is computed.
    pub formula: &'static str,
    /// What it is easily mistaken for, or what spoils it.
    pub trap: &'static str,
    /// Where the definition comes from.
    pub source: &'static str,
}

const HARTLEY: &str = "R. Hartley, A. Zisserman, Multiple View Geometry in Computer Vision, 2nd ed";
const PAPER: &str = "freeform prism for single-lens stereovision, Table 1";

const OWN: &str = "biprism";

macro_rules! meanings {
    ($([$label:literal, $key:literal, $formula:literal, $trap:literal, $source:expr],)*) => {
        [$(MetricMeaning { label: $label, key: $key, formula: $formula, trap: $trap, source: $source }),*]
    };
}

/// The meanings, in the order of the table.
pub const METRICS: [MetricMeaning; 29] = meanings![
    [
        "vertical disparity, RMS, px",
        "stereo/vertical_disparity_rms_px",
        "sqrt(sum (y_L - y_R)^2 / N) over the N corners of the board that both halves show, y from the top of each half",
        "It is of the raw halves. Calibration programs print it after rectification, where it tells the fit and not the optics.",
        "photogrammetry's y-parallax; the epipolar error of ROS camera_calibration, whose tutorial calls 0.25 px good and 0.1 px excellent"
    ],
    [
        "vertical disparity, largest, px",
        "stereo/vertical_disparity_max_px",
        "max |y_L - y_R| over the same corners",
        "One corner decides it; one that was matched to the wrong corner of the other half shows here first.",
        "NI Vision, maximum rectification error for horizontal epipolar lines"
    ],
    [
        "after one homography a half, RMS, px",
        "stereo/rectified_vertical_disparity_rms_px",
        "the same after each half was mapped by one homography, that of the cameras that fit best over all depths",
        "A homography undoes a turn, a roll and other focal lengths, which a mount could; what is left only a map or another prism can undo.",
        HARTLEY
    ],
    [
        "epipolar slope, mean, rad",
        "stereo/epipolar_slope_mean_rad",
        "mean of |slope| of the best line (total least squares) through the image, in the right half, of what one pixel of the left half sees over the depths",
        "Slopes of both signs do not cancel. It is of curves over the depths of the scene, not of one board.",
        HARTLEY
    ],
    [
        "epipolar slope, largest, rad",
        "stereo/epipolar_slope_max_rad",
        "the largest |slope| of these lines",
        "A slope over a short curve says little: a matcher feels slope times the disparity that it searches.",
        HARTLEY
    ],
    [
        "its rise over a half image, px",
        "stereo/epipolar_rise_max_px",
        "width of a half times tan of the largest |slope|",
        "No disparity is as large as a half image: the vertical disparity that a matcher meets is far less.",
        OWN
    ],
    [
        "epipolar curve from its line, RMS, px",
        "stereo/epipolar_departure_rms_px",
        "sqrt(sum d^2 / N) of the perpendicular distances of the curves' samples from their own best lines",
        "Two pinholes have straight lines, so that this is 0 for them however they are turned. It says nothing of slope.",
        OWN
    ],
    [
        "Table 1 (virtual image plane), mean |H|, mm",
        "pinhole/designed/mean_abs_h_mm",
        "mean of |x - x_ideal| where the rays beyond the glass, extended backwards, meet the designed virtual camera's image plane",
        "At z = -f of that camera, and a mean of magnitudes: not comparable with an RMS, nor with a reprojection error after a fit.",
        PAPER
    ],
    [
        "Table 1 (virtual image plane), mean |V|, mm",
        "pinhole/designed/mean_abs_v_mm",
        "mean of |y - y_ideal| on the same plane",
        "As above. The paper's average of the flat row, 0.0670 mm, is a misprint of 0.0770.",
        PAPER
    ],
    [
        "corners from their designed places, RMS, px",
        "pinhole/depths/designed/rms_px",
        "sqrt(sum |e|^2 / N), e a corner less where the designed virtual camera shows it, nothing fitted, the board at its own depth",
        "N counts vectors: a value over the 2N components is less by sqrt(2). A prism that is merely turned is blamed in full.",
        OWN
    ],
    [
        "corners from fitted pinhole, RMS, px",
        "pinhole/fitted/rms_px",
        "the same from the pinhole that fits the corners of all depths best: place, turn and one focal length free",
        "Calibration programs free more (principal point, distortion), and hide as much of the prism as these can take up.",
        "R. Tsai 1987 and every calibration since; ROS prints it over sqrt(2)"
    ],
    [
        "with f_x and f_y fitted apart, RMS, px",
        "pinhole/anamorphic/rms_px",
        "the same with a focal length for each axis",
        "A prism magnifies along the baseline: what this leaves less than the row above is that, and no error of a surface.",
        "OpenCV calibrateCamera without CALIB_FIX_ASPECT_RATIO"
    ],
    [
        "with the principal point too, RMS, px",
        "pinhole/principal/rms_px",
        "the same with the principal point free as well: ten numbers over several depths",
        "Over one depth it is not determined, and left out.",
        "OpenCV calibrateCamera"
    ],
    [
        "corners from designed centre by homography, px",
        "pinhole/homography/rms_px",
        "from the designed virtual camera after one homography of the half, over all depths",
        "The centre stays the designed one: what is left has no single centre there, whatever the image plane.",
        HARTLEY
    ],
    [
        "corners from fitted row law, RMS in u, px",
        "pinhole/row_law/rms_u_px",
        "sqrt(sum e_u^2 / N) from u = f_x X/Z + c_x, v = f_y Y/Z with a centre that is free in X and Z",
        "Along the rows, where a constant shift of each row costs a matcher nothing.",
        OWN
    ],
    [
        "RMS in v, px",
        "pinhole/row_law/rms_v_px",
        "sqrt(sum e_v^2 / N) from the same law",
        "Nothing turns the law or moves it up or down, so that this is what both halves have of vertical disparity.",
        OWN
    ],
    [
        "with kappa undone, RMS in u, px",
        "pinhole/row_law/undone_rms_u_px",
        "the same along the rows after each row was moved back by kappa(v) = b (sqrt(1 + v^2/f^2) - 1), the same at every depth",
        "kappa is the law of [prism.law] or of the design, and not fitted: a prism that does not have it gets worse here.",
        OWN
    ],
    [
        "with kappa undone, RMS in v, px",
        "pinhole/row_law/undone_rms_v_px",
        "the same across the rows",
        "Moving rows changes no v: it differs from the row above only by the fit.",
        OWN
    ],
    [
        "rows and columns from straight, RMS, px",
        "pinhole/straightness_rms_px",
        "sqrt(sum d^2 / N) of the inner corners of each row and column from the chord of its end corners",
        "The two end corners carry the line: their own errors are counted in all the others. ROS takes rows only.",
        "ROS camera_calibration, linear_error"
    ],
    [
        "best centre from designed one, left, mm",
        "halves/left/pinhole/centre/drift_mm",
        "distance from the designed centre of projection to the point nearest to all rays of the left half",
        "It goes along the axis most, where a half fixes it least. Measured over the corners and true over the whole half, the two differ.",
        OWN
    ],
    [
        "baseline, mm",
        "geometry/baseline_mm",
        "distance of the centres of the two pinholes fitted to the corners",
        "It trades with vergence and focal length in the fit; over one facing board it is not fixed.",
        HARTLEY
    ],
    [
        "vergence of the central rays, deg",
        "geometry/vergence_deg",
        "angle of the rays of the two half-image centres, positive where they converge before the cameras",
        "0 for parallel cameras; an exact prism is parallel by its rows and not by its central rays.",
        HARTLEY
    ],
    [
        "field of a half, horizontal, deg",
        "geometry/field_h_deg",
        "angle between the rays of the middles of the left and the right side of a half, mean of both halves",
        "What both halves see of a near board is less: by the baseline.",
        HARTLEY
    ],
    [
        "field of a half, vertical, deg",
        "geometry/field_v_deg",
        "angle between the rays of the middles of the top and the bottom",
        "As above.",
        HARTLEY
    ],
    [
        "depth for 1 px of disparity, at the board, mm",
        "geometry/depth_per_px_mm",
        "how far a point at the board moves along z while its disparity falls by 1 px: Z^2 / (f b) of parallel cameras",
        "It grows with the square of the depth. A better prism does not lower it; a longer baseline does.",
        HARTLEY
    ],
    [
        "depth by the designed pair, error RMS, mm",
        "stereo/depth_error_rms_mm",
        "sqrt(sum (Z - Z_true)^2 / N), Z = f b / (pitch d) by the columns of matched corners on the raw halves and the designed cameras",
        "Nothing is calibrated: it is what a user gets who believes the design.",
        HARTLEY
    ],
    [
        "of the true depth, %",
        "stereo/depth_error_rms_percent",
        "sqrt(sum ((Z - Z_true) / Z_true)^2 / N)",
        "As above; at another depth the percentage is another, since the error grows with Z^2.",
        HARTLEY
    ],
    [
        "corners found/fully visible + cut, false",
        "corners",
        "corners found of those whose four squares lie wholly in their half, found ones with a square cut by its border, and found ones that are none",
        "Figures rest on what was found: a missing row at the border makes a prism look better.",
        OWN
    ],
    [
        "error of the detector, RMS, px",
        "corners/rms_error_px",
        "sqrt(sum |e|^2 / N) of found less true corners, the true ones from rays traced backwards",
        "It is the floor under every measured figure, and no property of the prism. With effects that smear edges it holds their shift too.",
        OWN
    ],
];

/// The meaning of the row of this label, with or without its indent.
pub fn meaning(label: &str) -> Option<&'static MetricMeaning> {
    let label = label.trim_start();
    let detector = label.starts_with("found from true corners");
    METRICS.iter().find(|metric| metric.label == label || (detector && metric.key == "corners/rms_error_px"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::table;

    #[test]
    fn every_row_of_the_table_has_one_meaning_in_its_order() {
        let rows: Vec<String> = table::rows(&[]).into_iter().map(|row| row.label.trim_start().to_owned()).collect();
        let labels: Vec<&str> = METRICS.iter().map(|metric| metric.label).collect();
        assert_eq!(rows, labels);
        assert!(
            meaning("  RMS in v, px").is_some()
                && meaning("found from true corners, with roughness, RMS, px").is_some()
        );
    }
}
