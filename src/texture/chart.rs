//! A chart of Siemens stars and slanted squares, and its exact integral over a convex polygon.

use super::convex::Convex;
use glam::DVec2;

/// Dark sectors of a star, and as many light ones.
const SECTORS: usize = 18;
/// Half the side of a star, in cells.
const STAR: f64 = 0.45;
/// Half the side of a slanted square, in cells.
const SLANTED: f64 = 0.3;
/// By how much its sides are turned: the 5 deg of ISO 12233.
const SLANT_DEG: f64 = 5.0;
/// A polygon over more cells along a side is given the mean of the chart: wrong by at most a cell's width along its outline.
const MOST_CELLS: f64 = 64.0;
/// The shortest side of what the chart shows that studies of an instrument take for its lines, in cells.
pub(super) const FEATURE: f64 = 1.0 / 64.0;

/// Cells of side 1 with a star and a slanted square by turns, dark on light, the first with a star.
#[derive(Debug, Clone, PartialEq)]
pub struct Chart {
    columns: usize,
    rows: usize,
    /// The dark shapes of the two kinds of cells, about their middle.
    shapes: [Vec<DarkShape>; 2],
}

/// A dark polygon.
#[derive(Debug, Clone, PartialEq)]
struct DarkShape {
    outline: Vec<DVec2>,
    low: DVec2,
    high: DVec2,
    area: f64,
}

impl DarkShape {
    fn new(polygon: &Convex) -> Self {
        let [low, high] = polygon.bounds();
        Self { outline: polygon.vertices().to_vec(), low, high, area: polygon.area() }
    }

    fn holds(&self, place: DVec2) -> bool {
        let n = self.outline.len();
        (0..n).all(|k| (self.outline[(k + 1) % n] - self.outline[k]).perp_dot(place - self.outline[k]) >= 0.0)
    }
}

/// A square about the origin of side 2 `half`, turned by an angle.
fn turned_square(half: f64, angle_rad: f64) -> Convex {
    let turn = DVec2::new(libm::cos(angle_rad), libm::sin(angle_rad));
    Convex::new(&[(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|p| turn.rotate(DVec2::from(p) * half)))
}

impl Chart {
    /// A chart of so many cells.
    pub fn new(columns: usize, rows: usize) -> Self {
        let square = turned_square(STAR, 0.0);
        let direction = |k: usize| {
            let angle = std::f64::consts::TAU * k as f64 / (2 * SECTORS) as f64;
            DVec2::new(libm::cos(angle), libm::sin(angle))
        };
        let sector = |k: usize| {
            let [from, to] = [direction(2 * k), direction(2 * k + 1)];
            DarkShape::new(&square.cut(|p| from.perp_dot(p)).cut(|p| p.perp_dot(to)))
        };
        let star = (0..SECTORS).map(sector).collect();
        let slanted = vec![DarkShape::new(&turned_square(SLANTED, SLANT_DEG.to_radians()))];
        Self { columns, rows, shapes: [star, slanted] }
    }

    /// Columns and rows of cells.
    pub fn size(&self) -> DVec2 {
        DVec2::new(self.columns as f64, self.rows as f64)
    }

    /// The value, 0 or 1, at a place in cells from the upper left corner.
    pub fn at(&self, place: DVec2) -> f64 {
        let cell = place.floor().clamp(DVec2::ZERO, self.size() - 1.0);
        let dark = self.of(cell).iter().any(|shape| shape.holds(place - cell - 0.5));
        f64::from(u8::from(!dark))
    }

    fn of(&self, cell: DVec2) -> &[DarkShape] {
        &self.shapes[(cell.x as usize + cell.y as usize) % 2]
    }

    /// The integral over a polygon that lies on the chart, in cells from its upper left corner.
    pub fn integral(&self, polygon: &Convex) -> f64 {
        // Take the mean of the chart over very many cells.
        let [low, high] = polygon.bounds();
        let area = polygon.area();
        if (high - low).max_element() > MOST_CELLS {
            let dark: f64 = self.shapes.iter().flatten().map(|shape| shape.area).sum();
            return area * (1.0 - 0.5 * dark);
        }

        // Subtract what is dark, cell by cell.
        let last = self.size() - 1.0;
        let (first, last) = (low.floor().clamp(DVec2::ZERO, last), high.floor().clamp(DVec2::ZERO, last));
        let mut light = area;
        for row in first.y as usize..=last.y as usize {
            for column in first.x as usize..=last.x as usize {
                let cell = DVec2::new(column as f64, row as f64);
                let part = polygon.map(|p| p - cell - 0.5);
                let [low, high] = part.bounds();
                let touched = |shape: &&DarkShape| shape.low.cmplt(high).all() && low.cmplt(shape.high).all();
                let dark = self.of(cell).iter().filter(touched);
                light -= dark.map(|shape| part.within_polygon(&shape.outline).area()).sum::<f64>();
            }
        }
        light
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Parallelograms of a hundredth of a cell to three cells, also about the middle of a star, against 512 x 512 places: an edge
    /// is missed by half a place along its length, of up to 36 edges.
    #[test]
    fn the_mean_over_a_parallelogram_is_that_of_its_places() {
        const N: usize = 512;
        let chart = Chart::new(6, 5);
        let share = |k: usize| (k as f64 + 0.5) / N as f64;
        for k in 0..30 {
            let wave = |n: usize| libm::sin((k * n + n) as f64);
            let size = [0.01, 0.1, 0.4, 1.0, 3.0][k % 5];
            let (right, down) = (size * DVec2::new(1.0, 0.3 * wave(5)), size * DVec2::new(0.4 * wave(7), 0.8));
            let middle =
                DVec2::new(2.5, 2.5) + if k % 3 == 0 { DVec2::ZERO } else { DVec2::new(wave(13), 0.7 * wave(17)) };
            let from = middle - 0.5 * (right + down);
            let polygon = Convex::new(&[from, from + right, from + right + down, from + down]);
            let places = (0..N * N).map(|k| chart.at(from + right * share(k % N) + down * share(k / N)));
            let expected = places.sum::<f64>() / (N * N) as f64;
            let mean = chart.integral(&polygon) / polygon.area();
            assert!((mean - expected).abs() < 4e-3, "{k}: {mean} {expected}");
        }
    }

    /// Areas that are known without a program: half a star is dark, and a slanted square is a square.
    #[test]
    fn whole_cells_are_dark_by_the_areas_of_their_shapes() {
        let chart = Chart::new(2, 1);
        let cell = |x: f64| Convex::new(&[(x, 0.0), (x + 1.0, 0.0), (x + 1.0, 1.0), (x, 1.0)].map(DVec2::from));
        // The sectors of a square star are not all of one area, but dark and light ones are mirror images in the diagonals.
        assert!((1.0 - chart.integral(&cell(0.0)) - 0.5 * 0.81).abs() < 1e-14);
        assert!((1.0 - chart.integral(&cell(1.0)) - 0.36).abs() < 1e-14);
    }
}
