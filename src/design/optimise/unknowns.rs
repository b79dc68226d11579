//! The unknowns of a search: coefficients of both surfaces, free numbers of the law, and the focus.

use super::anchored::AnchoredBasis;
use super::passage::{Fixed, LAW_SEED, Partial};
use crate::design::designed_law::{DesignedLaw, LawNumber};
use crate::num::scalar::{Differentiable, Taylor};
use nalgebra::DVector;

/// A number that stays within `range` of `middle`: middle + range s/sqrt(1 + s^2) of the unknown s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bounded {
    pub(super) middle: f64,
    pub(super) range: f64,
}

/// A value nearer to the end of a range than this share of it is moved inwards, where an unknown still moves it.
const INNER_SHARE: f64 = 0.95;

impl Bounded {
    /// The unknown that stands for `value`.
    pub(super) fn unknown(self, value: f64) -> f64 {
        let share = ((value - self.middle) / self.range).clamp(-INNER_SHARE, INNER_SHARE);
        share / (1.0 - share * share).sqrt()
    }

    pub(super) fn at<N: Differentiable>(self, s: N) -> N {
        let length = (N::constant(1.0) + s * s).sqrt();
        N::constant(self.middle) + (s / length).times(self.range)
    }
}

/// How the unknowns are laid out, and what they stand for.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct UnknownsLayout {
    /// Front and back.
    pub(super) bases: [AnchoredBasis; 2],
    /// The law with the numbers that are not free.
    pub(super) law: DesignedLaw,
    /// The free numbers, each with its range.
    pub(super) free: Vec<(LawNumber, Bounded)>,
    /// The inverse distance of the lens's focus, in 1/mm, where it is free.
    pub(super) focus: Option<Bounded>,
}

/// What one set of unknowns stands for.
pub(super) struct TrialPrism<'a> {
    pub(super) layout: &'a UnknownsLayout,
    x: &'a [f64],
}

impl UnknownsLayout {
    /// How many unknowns there are.
    pub(super) fn len(&self) -> usize {
        self.law_start() + self.free.len() + usize::from(self.focus.is_some())
    }

    /// The place of the first number of the law.
    pub(super) fn law_start(&self) -> usize {
        self.bases[0].len() + self.bases[1].len()
    }

    pub(super) fn candidate<'a>(&'a self, x: &'a DVector<f64>) -> TrialPrism<'a> {
        TrialPrism { layout: self, x: x.as_slice() }
    }
}

impl<'a> TrialPrism<'a> {
    /// Front and back.
    pub(super) fn sheets(&self) -> [Fixed<'a>; 2] {
        let [front, back] = &self.layout.bases;
        let (c, rest) = self.x.split_at(front.len());
        [Fixed { basis: front, c }, Fixed { basis: back, c: &rest[..back.len()] }]
    }

    /// The unknowns of the law's numbers and of the focus.
    pub(super) fn others(&self) -> &'a [f64] {
        &self.x[self.layout.law_start()..]
    }

    /// The law's numbers, of which the free ones are those of `unknown`.
    fn law_numbers<N: Differentiable>(&self, mut numbers: [N; 5], unknown: impl Fn(usize, f64) -> N) -> [N; 5] {
        for (k, ((number, range), s)) in self.layout.free.iter().zip(self.others()).enumerate() {
            numbers[number.place()] = range.at(unknown(k, *s));
        }
        numbers
    }

    /// The law itself.
    pub(super) fn law(&self) -> DesignedLaw {
        let fixed = self.layout.law;
        let [fx, fy, cx, z, toe] = self.law_numbers(fixed.of::<f64>(0.0).numbers, |_, s| s);
        DesignedLaw {
            focal_mm: [fx, fy],
            centre_x_mm: cx,
            eye_mm: [fixed.eye_mm[0], 0.0, z],
            toe_rad: libm::atan(toe),
            ..fixed
        }
    }

    /// The law's numbers with their seeds.
    pub(super) fn seeded_law(&self) -> [Partial; 5] {
        self.law_numbers(self.layout.law.of::<Partial>(0.0).numbers, |k, s| Partial::variable(s, LAW_SEED + k))
    }

    /// The law's numbers along the line of `rates`.
    pub(super) fn moving_law(&self, rates: &[f64]) -> [Taylor; 5] {
        self.law_numbers(self.layout.law.of::<Taylor>(0.0).numbers, |k, s| Taylor([s, rates[k], 0.0]))
    }

    /// The focus, where it is free, of an `unknown` of its own.
    pub(super) fn focus<N: Differentiable>(&self, unknown: impl Fn(usize, f64) -> N) -> Option<N> {
        let k = self.layout.free.len();
        self.layout.focus.map(|focus| focus.at(unknown(k, self.others()[k])))
    }
}
