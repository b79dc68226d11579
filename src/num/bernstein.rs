//! Polynomials on 0..=1 in Bernstein form, whose coefficients bound them: a root cannot slip through.
//!
//! A polynomial lies between its least and its greatest coefficient, and has no more roots in 0..1 than its coefficients
//! change sign (Farin, Curves and Surfaces for CAGD, chapter 6). Halving the interval makes both sharp.

/// Halvings before an interval counts as a point: 2^-45 of the way, 1e-12 mm of 40 mm.
const HALVINGS: u32 = 45;

/// sum of b_i (n over i) s^i (1 - s)^(n - i) for s in 0..=1, of degree n up to [`MAX_DEGREE`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bernstein {
    degree: usize,
    b: [f64; MAX_DEGREE + 1],
}

impl Bernstein {
    /// 0, of degree 0.
    pub const ZERO: Self = Self::constant(0.0);

    /// A number, of degree 0.
    pub const fn constant(c: f64) -> Self {
        let mut b = [0.0; MAX_DEGREE + 1];
        b[0] = c;
        Self { degree: 0, b }
    }

    /// The straight line from `line[0]` at 0 to `line[1]` at 1, of degree `degree`, which is at least 1.
    pub fn line(line: [f64; 2], degree: usize) -> Self {
        let mut b = [0.0; MAX_DEGREE + 1];
        for (i, b) in b[..=degree].iter_mut().enumerate() {
            let share = i as f64 / degree as f64;
            *b = line[0] * (1.0 - share) + line[1] * share;
        }
        Self { degree, b }
    }

    /// The degree of the form; that of the polynomial may be lower.
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// Times the straight line from `line[0]` at 0 to `line[1]` at 1: one degree more.
    ///
    /// # Panics
    /// When the degree is [`MAX_DEGREE`] already.
    #[must_use]
    pub fn times_line(&self, line: [f64; 2]) -> Self {
        let n = self.degree + 1;
        let mut b = [0.0; MAX_DEGREE + 1];
        for (i, out) in b[..=n].iter_mut().enumerate() {
            let share = i as f64 / n as f64;
            let (here, before) = (if i < n { self.b[i] } else { 0.0 }, if i > 0 { self.b[i - 1] } else { 0.0 });
            *out = (1.0 - share) * here * line[0] + share * before * line[1];
        }
        Self { degree: n, b }
    }

    /// Plus a number.
    #[must_use]
    pub(crate) fn plus_constant(mut self, c: f64) -> Self {
        self.b[..=self.degree].iter_mut().for_each(|b| *b += c);
        self
    }

    /// Plus a form of the same degree.
    #[must_use]
    pub fn plus(mut self, other: &Self) -> Self {
        debug_assert_eq!(self.degree, other.degree);
        self.b[..=self.degree].iter_mut().zip(&other.b).for_each(|(a, b)| *a += b);
        self
    }

    /// The value at `s`, by de Casteljau's repeated means.
    pub fn value(&self, s: f64) -> f64 {
        let mut b = self.b;
        for n in (1..=self.degree).rev() {
            for i in 0..n {
                b[i] = b[i] * (1.0 - s) + b[i + 1] * s;
            }
        }
        b[0]
    }

    /// The halves over 0..=1/2 and 1/2..=1, each over 0..=1 of its own.
    fn halves(&self) -> [Self; 2] {
        let (mut first, mut second) = (*self, *self);
        for k in 1..=self.degree {
            for i in 0..=self.degree - k {
                second.b[i] = 0.5 * (second.b[i] + second.b[i + 1]);
            }
            first.b[k] = second.b[0];
        }
        [first, second]
    }

    /// Whether the coefficients allow a root: some is 0 or two have different signs.
    fn may_vanish(&self) -> bool {
        let b = &self.b[..=self.degree];
        !(b.iter().all(|b| *b > 0.0) || b.iter().all(|b| *b < 0.0))
    }

    /// The least root in 0..=1 to 2^-45, `None` where there is none. A place that comes as near to 0 as the rounding of
    /// the coefficients counts as a root: judge it by its value.
    pub fn first_root(&self) -> Option<f64> {
        let mut later: Vec<(Self, f64, u32)> = vec![(*self, 0.0, 0)];
        while let Some((p, start, depth)) = later.pop() {
            if !p.may_vanish() {
                continue;
            }
            if p.b[0] == 0.0 {
                return Some(start);
            }
            let width = 1.0 / (1u64 << depth) as f64;
            if depth == HALVINGS {
                return Some(start + 0.5 * width);
            }
            let [first, second] = p.halves();
            later.push((second, start + 0.5 * width, depth + 1));
            later.push((first, start, depth + 1));
        }
        None
    }
}

/// Highest total degree that a [`Poly2`](super::poly2::Poly2) accepts.
pub const MAX_DEGREE: usize = 20;

#[cfg(test)]
mod tests {
    use super::*;

    /// The product of s - root over `roots`.
    fn from_roots(roots: &[f64]) -> Bernstein {
        roots.iter().fold(Bernstein::constant(1.0), |p, r| p.times_line([-r, 1.0 - r]))
    }

    #[test]
    fn a_product_of_lines_vanishes_at_their_roots() {
        let p = from_roots(&[0.3, 0.7, -1.0]);
        assert_eq!(p.degree(), 3);
        for s in [0.0, 0.3, 0.45, 0.7, 1.0] {
            assert!((p.value(s) - (s - 0.3) * (s - 0.7) * (s + 1.0)).abs() < 1e-16, "{s}");
        }
        assert_eq!(Bernstein::line([2.0, 5.0], 4).value(0.25), 2.75);
    }

    #[test]
    fn the_least_root_is_found_however_close_the_next() {
        for apart in [0.5, 1e-3, 1e-6, 1e-7] {
            let root = from_roots(&[0.2 + apart, 0.2, 1.5, -0.1, 0.9]).first_root().expect("there are three");
            // Near a double root the value is eps at sqrt(eps) around it.
            assert!((root - 0.2).abs() < 1e-13 / apart, "{apart}: {root}");
        }
    }

    #[test]
    fn no_root_is_none_and_the_ends_count() {
        assert_eq!(from_roots(&[1.1, -0.1]).first_root(), None);
        assert_eq!(from_roots(&[0.5, 0.5]).plus_constant(1e-12).first_root(), None);
        assert_eq!(from_roots(&[0.0, 0.5]).first_root(), Some(0.0));
        assert!(from_roots(&[1.0]).first_root().is_some_and(|s| s > 1.0 - 1e-12));
    }
}
