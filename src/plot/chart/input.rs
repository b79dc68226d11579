//! The input of a chart: series, axes and labels.

use crate::plot::axis::Scale;

/// One measured point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Value on the horizontal axis.
    pub x: f64,
    /// Value on the vertical axis.
    pub y: f64,
    /// Ends of its error bar on the vertical axis, low and high.
    pub y_range: Option<[f64; 2]>,
}

impl Point {
    /// A point without an error bar.
    pub const fn new(x: f64, y: f64) -> Self {
        Self { x, y, y_range: None }
    }
}

/// How a series is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Look {
    /// A marker at each point.
    Markers,
    /// A line through the points, in their order.
    Line,
    /// A dashed line through the points, in their order: a law or a bound to compare with.
    DashedLine,
    /// Markers and a line.
    MarkersAndLine,
}

/// Points that belong together.
#[derive(Debug, Clone, PartialEq)]
pub struct ChartSeries {
    /// Name in the legend.
    pub name: String,
    /// How it is drawn.
    pub look: Look,
    /// Its points.
    pub points: Vec<Point>,
    /// Words beside the points, in their order; none where it ends or is empty. One that would cover a marker or other
    /// words is left out.
    pub labels: Vec<String>,
}

/// Settings of an axis.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisInput {
    /// Name with its unit: "time for one frame, s".
    pub name: String,
    /// Linear or logarithmic.
    pub scale: Scale,
    /// Smallest and largest value shown; from the data when `None`.
    pub range: Option<[f64; 2]>,
}

/// Whether the points that no other point beats are set off.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Front {
    /// All points are equal.
    None,
    /// The Pareto front where small x and small y are good: the points to which no other is better in one and at
    /// least as good in the other.
    SmallIsGood,
}

/// A chart.
#[derive(Debug, Clone, PartialEq)]
pub struct ChartInput {
    /// Heading.
    pub title: String,
    /// A line in smaller letters below it; none when empty.
    pub note: String,
    /// Horizontal axis.
    pub x: AxisInput,
    /// Vertical axis.
    pub y: AxisInput,
    /// What is shown, the first series first.
    pub series: Vec<ChartSeries>,
    /// Whether the best points are set off; series drawn as lines only do not take part.
    pub front: Front,
    /// Width and height of the figure in px; each held within 300..=4000.
    pub size_px: [u32; 2],
}
