//! Axes: from values to places, and the ticks between.

/// How values are spread along an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// Evenly by difference.
    Linear,
    /// Evenly by ratio; only values above 0 have a place.
    Log,
}

/// A range of values along a line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axis {
    scale: Scale,
    low: f64,
    high: f64,
}

/// A mark on an axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Tick {
    /// Place along the axis, 0..=1.
    pub share: f64,
    /// The value in words; `None` at a small tick.
    pub label: Option<String>,
}

impl Axis {
    /// The axis from `low` to `high`; where these do not make a range for the scale, the nearest that does.
    pub fn new(scale: Scale, low: f64, high: f64) -> Self {
        let fits = usable(scale, low) && usable(scale, high) && high - low > 1e-9 * low.abs().max(high.abs());
        if fits { Self { scale, low, high } } else { Self::around(scale, [low, high]) }
    }

    /// The smallest axis with round ends that holds all values which have a place on this scale.
    pub fn around(scale: Scale, values: impl IntoIterator<Item = f64>) -> Self {
        let range = values.into_iter().filter(|&v| usable(scale, v)).fold(None, |range: Option<(f64, f64)>, v| {
            Some(range.map_or((v, v), |(low, high)| (low.min(v), high.max(v))))
        });
        let (low, high) = match (scale, range) {
            (Scale::Linear, None) => (0.0, 1.0),
            (Scale::Linear, Some(range)) => around_linear(range),
            (Scale::Log, None) => (0.1, 10.0),
            (Scale::Log, Some(range)) => around_log(range),
        };
        Self { scale, low, high }
    }

    /// The smallest value.
    pub fn low(&self) -> f64 {
        self.low
    }

    /// The largest value.
    pub fn high(&self) -> f64 {
        self.high
    }

    /// Where a value lies: 0 at the low end, 1 at the high end, beyond for values beyond; `None` for a value that has
    /// no place on this scale.
    pub fn share(&self, value: f64) -> Option<f64> {
        let share = match self.scale {
            Scale::Linear => (value - self.low) / (self.high - self.low),
            Scale::Log if value > 0.0 => libm::log(value / self.low) / libm::log(self.high / self.low),
            Scale::Log => return None,
        };
        share.is_finite().then_some(share)
    }

    /// Ticks from low to high, about `count` of them with a label.
    pub fn ticks(&self, count: usize) -> Vec<Tick> {
        let values = match self.scale {
            Scale::Linear => linear_ticks(self.low, self.high, count.max(1)),
            Scale::Log => log_ticks(self.low, self.high, count.max(1)),
        };
        let tick = |(value, label)| {
            let share = self.share(value).filter(|share| (-1e-9..=1.0 + 1e-9).contains(share))?;
            Some(Tick { share: share.clamp(0.0, 1.0), label })
        };
        values.into_iter().filter_map(tick).collect()
    }
}

/// Values beyond this (or, on a log axis, below its inverse) are not drawn: their differences would overflow.
const LARGEST: f64 = 1e100;

fn usable(scale: Scale, value: f64) -> bool {
    value.abs() <= LARGEST && (scale == Scale::Linear || value >= 1.0 / LARGEST)
}

/// A round number `mantissa x 10^exponent`.
#[derive(Clone, Copy)]
struct Round {
    mantissa: i64,
    exponent: i32,
}

impl Round {
    fn value(self) -> f64 {
        // A division by an exact power is right to the last bit; a product with 0.1 is not.
        let power = libm::pow(10.0, f64::from(self.exponent.abs()));
        if self.exponent < 0 { self.mantissa as f64 / power } else { self.mantissa as f64 * power }
    }

    fn label(self) -> String {
        let Self { mantissa, exponent } = self;
        match exponent {
            _ if mantissa == 0 => "0".to_owned(),
            0..=4 => signed(&format!("{}", self.value())),
            ..0 if self.leading_exponent() >= -4 => signed(&format!("{:.*}", -exponent as usize, self.value())),
            _ => self.power_label(),
        }
    }

    fn power_label(self) -> String {
        let digits = self.mantissa.unsigned_abs().to_string();
        let sign = if self.mantissa < 0 { "−" } else { "" };
        let power = format!("10{}", superscript(self.leading_exponent()));
        match digits.trim_end_matches('0').split_at(1) {
            ("1", "") if sign.is_empty() => power,
            (first, "") => format!("{sign}{first}×{power}"),
            (first, rest) => format!("{sign}{first}.{rest}×{power}"),
        }
    }

    /// The power of ten of its first digit.
    fn leading_exponent(self) -> i32 {
        self.exponent + self.mantissa.unsigned_abs().checked_ilog10().unwrap_or(0) as i32
    }
}

/// A number in words, with a true minus sign.
fn signed(number: &str) -> String {
    number.replace('-', "−")
}

/// A power in words: ⁻¹².
pub(crate) fn superscript(exponent: i32) -> String {
    let raised = |c| match c {
        '-' => '⁻',
        digit => ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][digit as usize - '0' as usize],
    };
    exponent.to_string().chars().map(raised).collect()
}

/// The largest power of ten that is not above `value`, which is positive.
fn decade(value: f64) -> i32 {
    let guess = libm::floor(libm::log10(value)) as i32;
    // The logarithm of an exact power may round to either side.
    if (Round { mantissa: 1, exponent: guess + 1 }).value() <= value { guess + 1 } else { guess }
}

/// The largest of 1, 2 or 5 times a power of ten that is not above `value`, which is positive.
pub(crate) fn round_below(value: f64) -> f64 {
    let steps = [5, 2, 1].map(|mantissa| Round { mantissa, exponent: decade(value) }.value());
    steps.into_iter().find(|s| *s <= value).unwrap_or(value)
}

/// A number with so many significant digits: 0.0123, 1.20, 1234, 1.20×10⁻⁷; a dash for what is no number.
pub(crate) fn significant(value: f64, digits: usize) -> String {
    let digits = digits.clamp(1, 17);
    if value == 0.0 {
        return "0".to_owned();
    } else if !value.is_finite() {
        return "–".to_owned();
    }
    let written = format!("{value:.*e}", digits - 1);
    let Some((mantissa, exponent)) = written.split_once('e') else { return signed(&written) };
    let exponent: i32 = exponent.parse().unwrap_or(0);
    match exponent {
        -4..6 => signed(&format!("{value:.*}", (digits as i32 - 1 - exponent).max(0) as usize)),
        _ => format!("{}×10{}", signed(mantissa), superscript(exponent)),
    }
}

/// A number as short as six significant digits allow: 5, 0.02, 2×10⁻⁷.
pub fn short(value: f64) -> String {
    let written = significant(value, 6);
    let (number, power) = written.split_at(written.find('×').unwrap_or(written.len()));
    let number = if number.contains('.') { number.trim_end_matches('0').trim_end_matches('.') } else { number };
    format!("{number}{power}")
}

/// The smallest step of 1, 2 or 5 times a power of ten that is not below `least`.
fn round_step(least: f64) -> Round {
    let exponent = decade(least);
    let steps = [1, 2, 5].map(|mantissa| Round { mantissa, exponent });
    steps
        .into_iter()
        .find(|s| s.value() >= least * (1.0 - 1e-9))
        .unwrap_or(Round { mantissa: 1, exponent: exponent + 1 })
}

fn around_linear((low, high): (f64, f64)) -> (f64, f64) {
    // A range that is nothing beside its values would have ticks that all read the same.
    let least = 1e-9 * low.abs().max(high.abs());
    let pad = if low == high && low == 0.0 { 1.0 } else { 0.1 * low.abs() };
    let (low, high) = if high - low > least { (low, high) } else { (low - pad, high + pad) };
    let step = round_step((high - low) / 8.0);
    let times = |n: f64| Round { mantissa: step.mantissa * n as i64, ..step }.value();
    (times(libm::floor(low / step.value() + 1e-9)), times(libm::ceil(high / step.value() - 1e-9)))
}

fn around_log((low, high): (f64, f64)) -> (f64, f64) {
    let round = |value: f64, up: bool| {
        let exponent = decade(value);
        let steps =
            [(1, 0), (2, 0), (5, 0), (1, 1)].map(|(m, e)| Round { mantissa: m, exponent: exponent + e }.value());
        let found =
            if up { steps.into_iter().find(|s| *s >= value) } else { steps.into_iter().rev().find(|s| *s <= value) };
        found.unwrap_or(value)
    };
    let (low, high) = (round(low, false), round(high, true));
    if low < high { (low, high) } else { (round(0.9 * low, false), round(1.1 * high, true)) }
}

fn linear_ticks(low: f64, high: f64, count: usize) -> Vec<(f64, Option<String>)> {
    let step = round_step((high - low) / count as f64);
    let first = libm::ceil(low / step.value() - 1e-9) as i64;
    let last = libm::floor(high / step.value() + 1e-9) as i64;
    let tick = |n: i64| Round { mantissa: n * step.mantissa, ..step };
    (first..=last.min(first + 100)).map(|n| (tick(n).value(), Some(tick(n).label()))).collect()
}

fn log_ticks(low: f64, high: f64, count: usize) -> Vec<(f64, Option<String>)> {
    let (first, last) = (decade(low), decade(high));
    let decades = libm::log10(high / low);
    // Over many decades only each n-th is named; over few, parts of a decade too.
    let every = libm::ceil(decades / count as f64).max(1.0) as i32;
    let named: &[i64] = match decades {
        d if d < 1.0 => &[1, 2, 3, 4, 5, 6, 8],
        d if 2.0 * d <= count as f64 => &[1, 2, 5],
        _ => &[1],
    };
    let parts: &[i64] = if decades > 12.0 { &[1] } else { &[1, 2, 3, 4, 5, 6, 7, 8, 9] };
    // One way of writing for the whole axis.
    let plain = first >= -3 && last <= 4;
    let tick = |exponent: i32, mantissa: i64| {
        let round = Round { mantissa, exponent };
        let has_name = named.contains(&mantissa) && exponent.rem_euclid(every) == 0;
        (round.value(), has_name.then(|| if plain { round.label() } else { round.power_label() }))
    };
    (first..=last).flat_map(|e| parts.iter().map(move |&m| tick(e, m))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: &Axis, count: usize) -> Vec<String> {
        axis.ticks(count).into_iter().filter_map(|tick| tick.label).collect()
    }

    #[test]
    fn linear_ticks_are_round_and_plain() {
        let axis = Axis::around(Scale::Linear, [-0.31, 0.72]);
        assert_eq!((axis.low(), axis.high()), (-0.4, 0.8));
        assert_eq!(labels(&axis, 6), ["−0.4", "−0.2", "0", "0.2", "0.4", "0.6", "0.8"]);
        assert_eq!(labels(&Axis::new(Scale::Linear, 0.0, 20.0), 4), ["0", "5", "10", "15", "20"]);
        assert_eq!(labels(&Axis::new(Scale::Linear, 0.0, 3e-7), 3), ["0", "10⁻⁷", "2×10⁻⁷", "3×10⁻⁷"]);
        // Few ticks far from 0 have many digits.
        let label = |mantissa, exponent| Round { mantissa, exponent }.label();
        assert_eq!(
            [label(22_155, -5), label(-22_155, -9), label(10, -7), label(-1, -7)],
            ["0.22155", "−2.2155×10⁻⁵", "10⁻⁶", "−1×10⁻⁷"]
        );
    }

    #[test]
    fn log_ticks_are_decades_and_parts_of_few_decades() {
        assert_eq!(labels(&Axis::new(Scale::Log, 0.01, 100.0), 6), ["0.01", "0.1", "1", "10", "100"]);
        assert_eq!(labels(&Axis::new(Scale::Log, 1.0, 20.0), 6), ["1", "2", "5", "10", "20"]);
        assert_eq!(labels(&Axis::new(Scale::Log, 1e-12, 1.0), 4), ["10⁻¹²", "10⁻⁹", "10⁻⁶", "10⁻³", "10⁰"]);
        assert_eq!(Axis::new(Scale::Log, 1.0, 100.0).ticks(5).len(), 19);
    }

    #[test]
    fn shares_go_from_0_to_1_and_nowhere_for_what_has_no_place() {
        let axis = Axis::new(Scale::Log, 0.1, 10.0);
        assert!((axis.share(1.0).expect("1 is on the axis") - 0.5).abs() < 1e-15);
        assert_eq!([0.0, -1.0, f64::NAN, f64::INFINITY].map(|v| axis.share(v)), [None; 4]);
        assert_eq!(Axis::new(Scale::Linear, -1.0, 1.0).share(0.0), Some(0.5));
    }

    #[test]
    fn significant_digits() {
        let words = [0.0, 0.012_34, -1.0, 9.999, 123.4, 1234.5, -1e-20, 2.5e20].map(|v| significant(v, 3));
        assert_eq!(words, ["0", "0.0123", "−1.00", "10.0", "123", "1234", "−1.00×10⁻²⁰", "2.50×10²⁰"]);
        assert_eq!([f64::NAN, f64::INFINITY].map(|v| significant(v, 3)), ["–", "–"]);
        let words = [5.0, 0.02, 0.1 + 0.2, 2000.0, 1e300, f64::MIN_POSITIVE, -1e6].map(short);
        assert_eq!(words, ["5", "0.02", "0.3", "2000", "1×10³⁰⁰", "2.22507×10⁻³⁰⁸", "−1×10⁶"]);
    }

    #[test]
    fn every_range_gives_an_axis_with_ticks() {
        let hostile = [0.0, -0.0, 1.0, -7.25, 1e-300, 1e300, f64::MAX, f64::MIN_POSITIVE, f64::NAN, f64::INFINITY, 5.0];
        for scale in [Scale::Linear, Scale::Log] {
            for a in hostile {
                for b in hostile {
                    for axis in [Axis::new(scale, a, b), Axis::around(scale, [a, b])] {
                        assert!(axis.low() < axis.high(), "{axis:?}");
                        let ticks = axis.ticks(5);
                        assert!(!ticks.is_empty() && ticks.len() < 200, "{axis:?}: {ticks:?}");
                        assert!(ticks.windows(2).all(|pair| pair[0].share < pair[1].share), "{axis:?}: {ticks:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn an_axis_around_values_holds_them() {
        for values in [[3.0, 3.0], [0.003, 812.0], [99.0, 101.0], [1e9, 1e9 + 1e3], [0.1, 0.2]] {
            for scale in [Scale::Linear, Scale::Log] {
                let axis = Axis::around(scale, values);
                for share in values.map(|v| axis.share(v).expect("positive values have a place")) {
                    assert!((-1e-6..=1.0 + 1e-6).contains(&share), "{axis:?} {values:?}");
                }
            }
        }
    }
}
