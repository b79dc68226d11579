// Curves and marks by uPlot, in the colours of the page.
const pageData = JSON.parse(document.getElementById('data').textContent);

// Okabe and Ito's colours, which differ for the colour-blind too; the second list is for dark paper.
const SERIES_COLOURS = [
  ['#0072b2', '#c44f00', '#007f5c', '#a8407f', '#7a5c00', '#3a3a3a', '#5b3ea8', '#8a1f1f'],
  ['#56b4e9', '#ff9a57', '#3ed0a6', '#e09ac6', '#e8cf4a', '#d0d0d0', '#b9a2f0', '#ff8f8f'],
];
const SERIES_DASHES = [[], [8, 4], [2, 3], [10, 3, 2, 3], [5, 5], [1, 4], [12, 4], [3, 6]];
const darkPaper = window.matchMedia('(prefers-color-scheme: dark)');
const seriesColour = (k) => SERIES_COLOURS[darkPaper.matches ? 1 : 0][k % SERIES_COLOURS[0].length];
const styleValue = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

// A number to read, with at most four digits.
function readable(value) {
  if (value === null || value === undefined || Number.isNaN(value)) return '-';
  const size = Math.abs(value);
  if (value === 0 || (size >= 1e-3 && size < 1e5)) return String(Number(value.toPrecision(4)));
  return value.toExponential(2).replace(/\.?0*e\+?/, 'e');
}

// At most seven powers of ten within a range; twos and fives too where it is short.
function powersOfTen(least, most) {
  const [low, high] = [Math.ceil(Math.log10(least) - 1e-9), Math.floor(Math.log10(most) + 1e-9)];
  if (high - low < 2) {
    const all = [low - 1, low, low + 1, low + 2].flatMap((n) => [1, 2, 5].map((digit) => digit * 10 ** n));
    return all.filter((value) => value >= least * (1 - 1e-9) && value <= most * (1 + 1e-9));
  }
  const step = Math.max(1, Math.ceil((high - low) / 6));
  return Array.from({ length: Math.floor((high - low) / step) + 1 }, (_, k) => 10 ** (low + k * step));
}

// A chart of series with their own x: `axes.x` and `axes.y` are { label, log }, a series is { name, points: [[x, y], ..],
// marks: whether its points are marked, line: whether they are joined, band: whether it lies behind as a broad line }.
function drawChart(element, axes, series) {
  // Put all series on the x of all.
  const positive = ([x, y]) => (!axes.x.log || x > 0) && (!axes.y.log || y > 0) && Number.isFinite(x) && Number.isFinite(y);
  const shown = series.map((one) => ({ ...one, points: one.points.filter(positive).sort((p, q) => p[0] - q[0]) }));
  const tables = shown.map(({ points }) => [points.map((p) => p[0]), points.map((p) => p[1])]);
  const data = tables.length ? uPlot.join(tables) : [[]];

  const axis = ({ label, log }) => ({ label, splits: log ? (_, index, least, most) => powersOfTen(least, most) : undefined, stroke: styleValue('--ink'), grid: { stroke: styleValue('--line'), width: 1 },
    ticks: { stroke: styleValue('--line') }, filter: (_, splits) => splits, size: 62, labelSize: 24,
    values: (_, ticks) => ticks.map((tick) => (tick === null ? '' : readable(tick))) });
  const scale = ({ log }) => (log ? { distr: 3, log: 10, time: false } : { time: false });
  const value = (_, number) => readable(number);
  const options = {
    width: Math.max(260, element.clientWidth), height: 300,
    scales: { x: scale(axes.x), y: scale(axes.y) },
    axes: [{ ...axis(axes.x), size: 44 }, axis(axes.y)],
    cursor: { focus: { prox: 24 } }, focus: { alpha: 0.4 },
    series: [{ label: axes.x.label, value }, ...shown.map((one, k) => ({
      label: one.name, value, spanGaps: true, stroke: one.band ? styleValue('--line') : seriesColour(one.colour ?? k),
      width: one.band ? 9 : 2, dash: one.band ? undefined : SERIES_DASHES[(one.colour ?? k) % SERIES_DASHES.length],
      paths: one.line === false ? () => null : undefined, points: { show: Boolean(one.marks), size: 9 },
    }))],
  };
  element.replaceChildren();
  element.drawnAs = { axes, series };
  if (!shown.some(({ points }) => points.length)) {
    const words = document.createElement('p');
    words.className = 'hint';
    words.textContent = 'There is nothing to draw: no prism here has such numbers.';
    element.append(words);
    element.plot = null;
    return null;
  }
  const plot = new uPlot(options, data, element);
  element.plot = plot;
  if (!element.observed) {
    element.observed = true;
    new ResizeObserver(() => element.plot?.setSize({ width: Math.max(260, element.clientWidth), height: 300 })).observe(element);
  }
  return plot;
}

darkPaper.addEventListener('change', () => document.querySelectorAll('.chart').forEach((element) => {
  if (element.drawnAs) drawChart(element, element.drawnAs.axes, element.drawnAs.series);
}));
