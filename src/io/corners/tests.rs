use super::*;
use crate::vision::Polarity;
use glam::{DMat2, DVec2};
use std::path::Path;

fn quality(k: f64) -> Quality {
    Quality {
        covariance_px2: DMat2::from_cols_array(&[1e-4 * k, -1.3e-5, -1.3e-5, 2e-4]),
        contrast: 0.8 / k,
        residual: 1e-3 / 3.0,
        polarity: if k > 1.5 { Polarity::Main } else { Polarity::Anti },
    }
}

fn views() -> Vec<CornerView> {
    let corner = |i: i32, k: f64| ListedCorner {
        index: [i, -2],
        position_px: DVec2::new(100.0 / 3.0 * k, 7.25),
        quality: Some(quality(k)),
    };
    let view = |name: &str, corners: Vec<ListedCorner>| CornerView::bare(name.to_owned(), corners);
    vec![view("left", vec![corner(0, 1.0), corner(1, 2.0)]), view("right", vec![corner(0, 30.1)])]
}

const FORMATS: [CornerFormat; 3] = [CornerFormat::Csv, CornerFormat::Json, CornerFormat::OpenCv];

#[test]
fn what_is_written_reads_back() {
    let mut bare = views();
    bare.iter_mut().flat_map(|v| &mut v.corners).for_each(|c| c.quality = None);
    for views in [views(), bare] {
        for format in FORMATS {
            let back = parse(&to_text(&views, format), format, "a").unwrap();
            for (a, b) in views.iter().zip(&back) {
                assert_eq!(a.index_origin, b.index_origin, "{format:?}");
                assert_eq!((a.name.as_str(), a.corners.len()), (b.name.as_str(), b.corners.len()), "{format:?}");
                for (a, b) in a.corners.iter().zip(&b.corners) {
                    assert_eq!((a.index, a.quality), (b.index, b.quality), "{format:?}");
                    // Half an ulp of 1000 px where half a pixel is taken off and put back; else exactly.
                    let allowed = if format == CornerFormat::OpenCv { 1.2e-13 } else { 0.0 };
                    assert!(a.position_px.distance(b.position_px) <= allowed, "{format:?}");
                }
            }
        }
    }
}

/// What indices count from is written where it is known of all views; another word is refused.
#[test]
fn the_origin_of_the_indices_reads_back_or_is_refused() {
    for format in FORMATS {
        let mut views = views();
        views.iter_mut().for_each(|view| view.index_origin = Some(IndexOrigin::Board));
        let text = to_text(&views, format);
        assert!(parse(&text, format, "a").unwrap().iter().all(|v| v.index_origin == Some(IndexOrigin::Board)));
        let error = parse(&text.replace("board", "table"), format, "a").unwrap_err();
        assert!(error.rule.contains("\"table\"") && error.rule.contains("\"lattice\""), "{format:?}: {error}");
        views[0].index_origin = None;
        assert!(parse(&to_text(&views, format), format, "a").unwrap().iter().all(|v| v.index_origin.is_none()));
    }
}

#[test]
fn quality_is_written_of_every_corner_or_of_none() {
    let mut mixed = views();
    mixed[1].corners[0].quality = None;
    for format in [CornerFormat::Csv, CornerFormat::OpenCv] {
        let back = parse(&to_text(&mixed, format), format, "a").unwrap();
        assert!(back.iter().flat_map(|v| &v.corners).all(|c| c.quality.is_none()), "{format:?}");
    }
}

#[test]
fn json_keeps_blur_and_counts() {
    let mut views = views();
    views[0].blur_px = Some([0.7, 0.71]);
    views[0].rejected = vec![("cut".to_owned(), 3), ("ring".to_owned(), 5)];
    assert_eq!(parse(&to_text(&views, CornerFormat::Json), CornerFormat::Json, "a").unwrap(), views);
}

#[test]
fn opencv_positions_are_half_a_pixel_less() {
    let text = to_text(&views(), CornerFormat::OpenCv);
    let head = "%YAML:1.0\n---\npixel_centre: \"(i, j)\"\ncorners: 3\nleft_corners: !!opencv-matrix\n   rows: 2\n";
    assert!(text.starts_with(head));
    assert!(text.contains("data: [ 32.833333333333336, 6.75,\n"), "{text}");
}

#[test]
fn what_opencv_writes_is_read() {
    // As cv::FileStorage writes a vector of Point2f and one of Point.
    let text = "%YAML:1.0\n---\npixel_centre: \"(i, j)\"\nwhole_corners: !!opencv-matrix\n   rows: 2\n   cols: 1\n   dt: \"2f\"\n   \
                data: [ 1., 2.50000000e+00,\n       3.25000000e+00, 4. ]\nwhole_index: !!opencv-matrix\n   rows: 2\n   cols: 2\n   \
                dt: i\n   data: [ 0, 0, 1, 0 ]\n";
    let views = parse(text, CornerFormat::OpenCv, "a").unwrap();
    // Version 5 begins otherwise; comments and lists of other programs do no harm.
    let newer = text.replace("%YAML:1.0\n---\n", "%YAML 1.2\n---\n# made by hand\nfiles:\n   - \"a.png\"\n");
    assert_eq!(parse(&newer, CornerFormat::OpenCv, "a").unwrap(), views);
    let positions: Vec<DVec2> = views[0].corners.iter().map(|c| c.position_px).collect();
    assert_eq!(positions, [DVec2::new(1.5, 3.0), DVec2::new(3.75, 4.5)]);
    assert_eq!(views[0].corners[1].index, [1, 0]);
}

#[test]
fn bad_files_are_refused_with_place_and_rule() {
    let good = |format| to_text(&views(), format);
    let csv = |from: &str, to: &str| (CornerFormat::Csv, good(CornerFormat::Csv).replacen(from, to, 1));
    let json = |from: &str, to: &str| (CornerFormat::Json, good(CornerFormat::Json).replacen(from, to, 1));
    let yaml = |from: &str, to: &str| (CornerFormat::OpenCv, good(CornerFormat::OpenCv).replacen(from, to, 1));
    let cases = [
        (csv("# pixel centre: ", "# "), "a:1", "must name where a pixel's centre lies"),
        (csv("(i + 0.5, j + 0.5)", "(i, j)"), "a:1", "the pixel centre is \"(i, j)\""),
        (csv("corners: 3", "corners: many"), "a:2", "`corners` is \"many\""),
        (csv("corners: 3", "corners: 4"), "a", "holds 3 corners, and says that it has 4"),
        (csv("column,row", "row,column"), "a:3", "the columns are"),
        (csv("left,0,-2,", "left,0,"), "a:4", "10 values, and must have 11"),
        (csv("left,1,", "left,1.5,"), "a:5", "`column` is \"1.5\""),
        (csv("left,1,", "left,99999999999,"), "a:5", "`column`"),
        (csv("left,1,", "left,1000001,"), "a", "within 1000000 of 0"),
        ((CornerFormat::Csv, good(CornerFormat::Csv).trim_end().to_owned()), "a:6", "the last line has no end"),
        (csv(",7.25,", ",NaN,"), "a", "must lie at finite px"),
        (csv(",7.25,", ",7,25,"), "a:4", "12 values"),
        (csv(",anti", ",both"), "a:4", "`polarity` is \"both\""),
        (csv("left,1,", "left,0,"), "a", "there twice"),
        (csv("left", "../etc"), "a", "letters a to z"),
        (csv(",0.0001,", ",-0.0001,"), "a", "symmetric, positive"),
        (json("\"pixel_centre\": \"(i + 0.5, j + 0.5)\",", ""), "a:", "missing field `pixel_centre`"),
        (json("(i + 0.5, j + 0.5)", "(i, j)"), "a", "`pixel_centre` is \"(i, j)\""),
        (json("\"index\"", "\"indices\""), "a:", "unknown field `indices`"),
        (json("\"contrast\": 0.8,", ""), "a", "or none"),
        (json("7.25", "1e999"), "a:", "number out of range"),
        (yaml("%YAML:1.0", "%TOML 1.0"), "a", "the first line is"),
        (yaml("pixel_centre", "pixel_center"), "a", "`pixel_centre` is missing"),
        (yaml("left_index", "left_indices"), "a", "`left_index` is missing"),
        ((CornerFormat::OpenCv, "%YAML:1.0\npixel_centre: \"(i, j)\"\n".to_owned()), "a", "no matrix is named"),
        (yaml("right_quality", "right_qualities"), "a", "`right_quality` is missing"),
        (yaml("corners: 3", "corners: -3"), "a", "`corners` is \"-3\""),
        (yaml("corners: 3", "corners: 2"), "a", "holds 3 corners, and says that it has 2"),
        (yaml("rows: 2", "rows: 3"), "a:5", "holds 4 numbers, and must hold 3 rows of 2"),
        (yaml("rows: 2", "rows: 99999999999"), "a:5", "more than 1000000 corners"),
        (yaml("rows: 2", "rows: -1"), "a:5", "`rows` of `left_corners` is \"-1\""),
        (yaml("\"2d\"", "\"2x\""), "a:5", "`dt` of `left_corners`"),
        (yaml("\"2d\"", "é"), "a:5", "`dt` of `left_corners`"),
        (yaml("6.75", "6,75"), "a:5", "holds 5 numbers"),
        (yaml("6.75", ".Nan"), "a:5", "must hold numbers"),
    ];
    for ((format, text), place, rule) in cases {
        let problem = parse(&text, format, "a").expect_err(rule);
        let told = problem.render(false);
        assert!(told.contains(&format!(" {place}")), "{told}: {rule}");
        assert!(problem.rule.contains(rule), "{} does not say {rule}", problem.rule);
        assert!(!problem.help.is_empty());
    }
}

#[test]
fn nonsense_is_refused_without_panic() {
    for format in FORMATS {
        for text in
            ["", "\n", "%YAML:1.0", "%YAML:1.0\n---\n", "{}", "[", "\u{feff}", "a,b\n", "%YAML:1.0\n  x", "é:é\n\"é"]
        {
            // An empty OpenCV file lacks its convention, an empty CSV its first line: nothing here is a corner file.
            assert!(parse(text, format, "a").is_err(), "{format:?} {text:?}");
        }
        // Cut anywhere: an error, but for the blanks after the last bracket.
        let good = to_text(&views(), format);
        for end in 0..good.trim_end().len() {
            assert!(parse(&good[..end], format, "a").is_err(), "{format:?} {end} {:?}", &good[..end]);
        }
    }
}

#[test]
fn files_go_by_their_ending() {
    assert_eq!(CornerFormat::of(Path::new("a/b.YAML")), Ok(CornerFormat::OpenCv));
    assert!(CornerFormat::of(Path::new("a.txt")).is_err());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("corners.csv");
    assert!(read(&path).is_err());
    crate::io::atomic::write_bytes(&path, to_text(&views(), CornerFormat::Csv).as_bytes()).unwrap();
    assert_eq!(read(&path).unwrap(), views());
}
