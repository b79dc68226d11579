//! Sampling: squares far below and far above a pixel, corners on borders, sensors of one pixel, one row, one column.

use super::case::{Case, ErrorUnit};
use super::scenes::{BOARD, FLAT, NO_GLASS, built};
use super::tables::PRISM;
use super::tally::{CaseOutcome, Tally};
use crate::accuracy::Accuracy;
use crate::render;

/// The mean of the default black and white.
const MEAN: f64 = 0.45;
/// Half the difference of white and black.
const AMPLITUDE: f64 = 0.4;

pub(super) const CASES: &[Case] = &[
    Case {
        group: "sampling",
        name: "squares far below a pixel",
        hard: "10 ... 4e4 squares across each pixel, flat prism",
        property: "the picture tends to the mean radiance: the largest departure from it times the squares in a pixel",
        unit: ErrorUnit::Radiance,
        bound: 4.0 * AMPLITUDE,
        why: "only the squares on a pixel's outline do not cancel: at most 4 of its sides' worth, each less than a square",
        run: fine_squares,
    },
    Case {
        group: "sampling",
        name: "one square fills the view",
        hard: "a square of 1e6 mm, black in the middle",
        property: "every pixel is that square's radiance",
        unit: ErrorUnit::Radiance,
        bound: 1e-8,
        why: "f32 of 0.05",
        run: one_square,
    },
    Case {
        group: "sampling",
        name: "corners on borders",
        hard: "corners exactly on a pixel's border, on its centre, on the image border and on the seam; squares of one \
               pixel exactly",
        property: "a pixel with the corner at (a, b) inside it has the closed form (1 - (2a - 1)(2b - 1)) / 2 of its two \
                   radiances",
        unit: ErrorUnit::Radiance,
        bound: 1e-7,
        why: "f32 of radiances up to 1",
        run: corners,
    },
    Case {
        group: "sampling",
        name: "coverage of the standard level",
        hard: "edges across pixels in which the map bends, full resolution, flat and polynomial prism",
        property: "each pixel against the reference level, as the shift of an edge between black and white in px",
        unit: ErrorUnit::Px,
        bound: 2e-5,
        why: "`bend_px` of the standard level: a pixel is divided until no part bends by more",
        run: levels,
    },
    Case {
        group: "sampling",
        name: "sensors of extreme shape",
        hard: "1 x 1, 1 x 97, 97 x 1, 2 x 2, 16384 x 2 and 2 x 16384 pixels",
        property: "every pixel is a number within the board's radiances",
        unit: ErrorUnit::Radiance,
        bound: 1e-7,
        why: "f32 of radiances up to 1",
        run: extreme_sensors,
    },
];

fn fine_squares() -> CaseOutcome {
    let mut tally = Tally::default();
    // 480 pixels over the paper's field are 0.63 mm wide on the board.
    for square in [6e-2, 1.3e-2, 1e-3, 1e-4, 1.7e-5] {
        let board =
            format!("columns = 100000\nrows = 100000\nsquare_mm = {square:?}\nposition_mm = [0.0, 0.0, 1000.0]");
        let film = render::render(&built([480, 16], "", FLAT, &board), &());
        let plate = 0.5 * 100_000.0 * square;
        let squares = 0.63 / square;
        for (value, mm) in film.radiance.data().iter().zip(film.board_mm.iter().flat_map(|board_mm| board_mm.data())) {
            // Where the plate ends within the pixel, its surroundings count.
            if mm.iter().all(|c| f64::from(c.abs()) + 2.0 < plate) {
                tally.error(|| format!("square {square}, at {mm:?}"), (f64::from(*value) - MEAN) * squares.min(4096.0));
            }
        }
    }
    tally.done()
}

fn one_square() -> CaseOutcome {
    let mut tally = Tally::default();
    for prism in [FLAT, NO_GLASS] {
        let board = "columns = 1\nrows = 1\nsquare_mm = 1e6\nposition_mm = [0.0, 0.0, 1000.0]";
        let film = render::render(&built([65, 37], "", prism, board), &());
        for value in film.radiance.data() {
            tally.error(|| format!("{value}"), f64::from(*value) - 0.05);
        }
        tally.require(film.counts.edge_pixels == 0, || "a pixel without an edge is integrated".to_owned());
    }
    tally.done()
}

fn corners() -> CaseOutcome {
    let mut tally = Tally::default();
    // f = 35 mm, 96 px of 0.11 mm, board at 1000 mm without glass: a pixel is 22/7 mm wide. The board's corner (0, 0) of
    // an even board is moved by any share of a pixel.
    let pixel_mm = 1000.0 * 0.11 / 35.0;
    for (a, b) in [(0.0, 0.0), (0.5, 0.5), (0.25, 0.0), (0.0, 0.75), (0.125, 0.875), (1e-12, 0.5), (1.0, 1.0 - 1e-12)] {
        for pixel in [[48, 27], [0, 0], [95, 53], [48, 0]] {
            let corner = [pixel[0] as f64 + a - 48.0, pixel[1] as f64 + b - 27.0].map(|c| c * pixel_mm);
            let board = format!(
                "columns = 2\nrows = 2\nsquare_mm = 1000.0\nposition_mm = [{:?}, {:?}, 1000.0]",
                corner[0], corner[1]
            );
            let film = render::render(&built([96, 54], "", NO_GLASS, &board), &());
            // The top left square is black, and so is the bottom right one.
            let black = a * b + (1.0 - a) * (1.0 - b);
            let expected = 0.85 - 0.8 * black;
            tally.error(
                || format!("corner at ({a}, {b}) of pixel {pixel:?}"),
                f64::from(film.radiance.get(pixel[0], pixel[1])) - expected,
            );
        }
    }
    // Squares of exactly one pixel, shifted by half a pixel: every pixel holds a corner in its middle.
    let board = format!(
        "columns = 200\nrows = 200\nsquare_mm = {pixel_mm:?}\nposition_mm = [{0:?}, {0:?}, 1000.0]",
        0.5 * pixel_mm
    );
    let film = render::render(&built([96, 54], "", NO_GLASS, &board), &());
    for value in film.radiance.data() {
        tally.error(|| format!("{value} in a picture of corners"), f64::from(*value) - MEAN);
    }
    tally.done()
}

fn levels() -> CaseOutcome {
    let mut tally = Tally::default();
    for prism in [FLAT, PRISM] {
        // Rows through the middle; a pitch of 80 squares over the field puts edges at all places in a pixel.
        let board = BOARD.replace("10.0", "3.7").replace("41", "99");
        let standard = built([1920, 12], "", prism, &board);
        let reference = standard.with_accuracy(Accuracy::reference());
        let [a, b] = [standard, reference].map(|system| render::render(&system, &()).radiance);
        for (k, (x, y)) in a.data().iter().zip(b.data()).enumerate() {
            tally.error(|| format!("({}, {})", k % 1920, k / 1920), f64::from(x - y) / (2.0 * AMPLITUDE));
        }
    }
    tally.done()
}

fn extreme_sensors() -> CaseOutcome {
    let mut tally = Tally::default();
    for size in [[1, 1], [1, 97], [97, 1], [2, 2], [16384, 2], [2, 16384]] {
        for prism in [FLAT, NO_GLASS] {
            // The field is the paper's in width; a tall sensor sees past the board and, through a prism, much glass.
            let prism = if size[1] > 2 * size[0] { NO_GLASS } else { prism };
            let film = render::render(&built(size, "", prism, BOARD), &());
            for value in film.radiance.data() {
                let value = f64::from(*value);
                tally.error(|| format!("{value} on {size:?}"), (0.05 - value).max(value - 0.85).max(0.0));
            }
        }
    }
    tally.done()
}
