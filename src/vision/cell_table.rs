//! The numbers of a lattice's corners by their cells, in a table: the lines through corners ask for them over and over.

use super::lattice_growth::Lattice;
use glam::IVec2;

/// A table has at most so many cells for each corner: a sparser lattice is asked itself.
const MOST_CELLS: usize = 64;
/// The number of a cell without a corner.
const NONE: u32 = u32::MAX;

/// A lattice that is asked by a table where it is dense enough.
#[derive(Debug)]
pub(super) struct CellTable {
    lattice: Lattice,
    /// The first column and row of the table, and how many there are; none of a sparse lattice.
    low: IVec2,
    size: IVec2,
    /// Column by column.
    numbers: Vec<u32>,
}

impl CellTable {
    pub(super) fn new(lattice: Lattice) -> Self {
        // Find the rectangle about the cells.
        let cells = || lattice.keys().map(|&cell| IVec2::from_array(cell));
        let low = cells().reduce(IVec2::min).unwrap_or_default();
        let size = cells().reduce(IVec2::max).map_or(IVec2::ZERO, |high| high - low + 1);
        let area = size.x as usize * size.y as usize;
        if area > MOST_CELLS * lattice.len() || lattice.values().any(|&k| k >= NONE as usize) {
            return Self { lattice, low, size: IVec2::ZERO, numbers: Vec::new() };
        }

        // Enter the numbers.
        let mut table = Self { lattice, low, size, numbers: vec![NONE; area] };
        for (&cell, &number) in &table.lattice {
            let place = (IVec2::from_array(cell) - low).as_usizevec2();
            table.numbers[place.x * size.y as usize + place.y] = number as u32;
        }
        table
    }

    /// The lattice.
    pub(super) fn lattice(&self) -> &Lattice {
        &self.lattice
    }

    /// The number of the corner at a cell.
    #[inline]
    pub(super) fn number(&self, cell: IVec2) -> Option<usize> {
        if self.numbers.is_empty() {
            return self.lattice.get(&cell.to_array()).copied();
        }
        let number = self.numbers[self.place(cell)?];
        (number != NONE).then_some(number as usize)
    }

    /// Takes the corner at a cell out, and gives its number.
    pub(super) fn remove(&mut self, cell: [i32; 2]) -> Option<usize> {
        if let Some(place) = self.place(IVec2::from_array(cell)) {
            self.numbers[place] = NONE;
        }
        self.lattice.remove(&cell)
    }

    /// The place of a cell in the table.
    #[inline]
    fn place(&self, cell: IVec2) -> Option<usize> {
        let at = cell - self.low;
        let within = at.x >= 0 && at.y >= 0 && at.x < self.size.x && at.y < self.size.y;
        within.then(|| at.x as usize * self.size.y as usize + at.y as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A rectangle with holes, which is held in a table, and a cross of long arms, which is not.
    #[test]
    fn every_cell_is_told_as_the_lattice_tells_it() {
        let holed = (0..63).filter(|k| k % 5 != 0).map(|k| [k % 7 - 3, k / 7 - 20]);
        let cross = (-200..200).flat_map(|k| [[k, 0], [0, k]]);
        for (cells, dense) in [(holed.collect::<Vec<_>>(), true), (cross.collect(), false)] {
            let lattice: Lattice = cells.iter().enumerate().map(|(k, &cell)| (cell, k)).collect();
            let mut table = CellTable::new(lattice.clone());
            assert_eq!(table.numbers.is_empty(), !dense);
            assert_eq!(table.remove(cells[3]), lattice.get(&cells[3]).copied());
            assert_eq!(table.remove([777, 0]), None);
            for cell in (-30..30).flat_map(|x| (-30..30).map(move |y| [x, y])) {
                let expected = lattice.get(&cell).copied().filter(|_| cell != cells[3]);
                assert_eq!(table.number(IVec2::from_array(cell)), expected, "{cell:?}");
                assert_eq!(table.lattice().get(&cell).copied(), expected);
            }
        }
        assert_eq!(CellTable::new(Lattice::new()).number(IVec2::ZERO), None);
    }
}
