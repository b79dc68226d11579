//! A spatial index of candidates.

use super::candidate::Candidate;
use glam::DVec2;

/// A spatial index of the candidates.
pub(super) struct Buckets {
    columns: usize,
    rows: usize,
    cells: Vec<Vec<usize>>,
    /// Column and row of the bucket of each.
    places: Vec<[usize; 2]>,
}

/// Side of a bucket, in px.
const BUCKET_PX: f64 = 16.0;

impl Buckets {
    pub(super) fn new(candidates: &[Candidate]) -> Self {
        let largest = candidates.iter().fold(DVec2::ZERO, |m, c| m.max(c.position));
        let columns = (largest.x / BUCKET_PX) as usize + 1;
        let rows = (largest.y / BUCKET_PX) as usize + 1;
        let mut cells = vec![Vec::new(); columns * rows];
        let place = |candidate: &Candidate| {
            let at = (candidate.position / BUCKET_PX).max(DVec2::ZERO);
            [at.x as usize, at.y as usize]
        };
        let places: Vec<[usize; 2]> = candidates.iter().map(place).collect();
        for (k, [column, row]) in places.iter().enumerate() {
            cells[row * columns + column].push(k);
        }
        Self { columns, rows, cells, places }
    }

    /// The candidates in the buckets that a circle touches.
    pub(super) fn around(&self, point: DVec2, radius: f64) -> impl Iterator<Item = usize> + '_ {
        // A float to usize cast saturates, so a circle outside the picture asks for an empty or a border range.
        let low = (point - radius) / BUCKET_PX;
        let high = (point + radius) / BUCKET_PX;
        let columns = low.x as usize..(high.x + 1.0).max(0.0).min(self.columns as f64) as usize;
        let rows = low.y as usize..(high.y + 1.0).max(0.0).min(self.rows as f64) as usize;
        // Where the buckets are more than the candidates, look at each of these.
        let many = rows.len() * columns.len() > self.places.len();
        let (all, by_rows) = if many { (self.places.len(), 0..0) } else { (0, rows.clone()) };
        let within = columns.clone();
        let single = (0..all).filter(move |&k| {
            let [column, row] = self.places[k];
            within.contains(&column) && rows.contains(&row)
        });
        let bucketed = by_rows
            .flat_map(move |row| columns.clone().map(move |column| row * self.columns + column))
            .flat_map(|cell| self.cells[cell].iter().copied());
        single.chain(bucketed)
    }
}
