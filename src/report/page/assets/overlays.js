// Corners, error vectors and heat map, in px of the window.
const CORNER = { half: 0, column: 1, row: 2, x: 3, y: 4, isTrue: 5, ideal: 7, spread: 9, steps: 12 };

// Viridis at nine places (Smith and van der Walt 2015, CC0), turned round so that small errors are light.
const RAMP = ['#fde725', '#addc30', '#5ec962', '#28ae80', '#21918c', '#2c728e', '#3b528b', '#472d7b', '#440154'];

function mixed(share) {
  const place = Math.min(Math.max(share, 0), 1) * (RAMP.length - 1);
  const low = Math.min(Math.floor(place), RAMP.length - 2);
  const part = (hex, k) => parseInt(hex.slice(1 + 2 * k, 3 + 2 * k), 16);
  const one = (k) => Math.round(part(RAMP[low], k) + (part(RAMP[low + 1], k) - part(RAMP[low], k)) * (place - low));
  return `rgb(${one(0)} ${one(1)} ${one(2)})`;
}

// The error vector of a corner by the kind that is asked for; null where it is not known.
function errorOf(corner, kind) {
  const step = pageData.budget_steps.indexOf(kind);
  const at = step >= 0 ? CORNER.steps + 2 * step : kind === 'true' ? CORNER.isTrue : CORNER.ideal;
  const [x, y] = [corner[at], corner[at + 1]];
  return x === null || x === undefined ? null : { x, y, length: Math.hypot(x, y) };
}

// The range of colours over all prisms: from the longest error down by three decades at most.
function errorRange(kind) {
  const all = pageData.prisms.flatMap((prism) => prism.corners.map((corner) => errorOf(corner, kind)?.length ?? 0));
  const sizes = all.filter((length) => length > 0);
  const high = sizes.reduce((a, b) => Math.max(a, b), 0);
  const low = sizes.reduce((a, b) => Math.min(a, b), high);
  return high > 0 ? { high, low: Math.max(low, high / 1000), clipped: low < high / 1000 } : null;
}

const errorColour = (length, range) =>
  mixed(range.high > range.low ? Math.log(Math.max(length, range.low) / range.low) / Math.log(range.high / range.low) : 1);

// The steps from a corner to its neighbours along the rows and the columns, in px: medians of the prism.
function cornerSteps(prism) {
  const known = new Map(prism.corners.map((c) => [`${c[0]},${c[1]},${c[2]}`, c]));
  const median = (column, row, axis) => {
    const steps = prism.corners.flatMap((c) => {
      const next = known.get(`${c[0]},${c[1] + column},${c[2] + row}`);
      return next ? [Math.abs(next[axis] - c[axis])] : [];
    }).sort((a, b) => a - b);
    return steps.length ? steps[steps.length >> 1] : 20;
  };
  return { x: median(1, 0, CORNER.x), y: median(0, 1, CORNER.y) };
}

function drawHeat(ctx, prism, view, kind) {
  const range = errorRange(kind);
  if (!range) return;
  prism.steps ??= cornerSteps(prism);
  const [w, h] = [prism.steps.x * view.scale, prism.steps.y * view.scale];
  ctx.globalAlpha = 0.72;
  for (const corner of prism.corners) {
    const error = errorOf(corner, kind);
    if (!error) continue;
    ctx.fillStyle = errorColour(error.length, range);
    const [x, y] = [view.x + corner[CORNER.x] * view.scale, view.y + corner[CORNER.y] * view.scale];
    const [left, top] = [Math.round(x - w / 2), Math.round(y - h / 2)];
    ctx.fillRect(left, top, Math.round(x + w / 2) - left, Math.round(y + h / 2) - top);
  }
  ctx.globalAlpha = 1;
}

// A line with a rim, to be seen on light and dark squares.
function rimmed(ctx, path, colour, width) {
  for (const [style, wide] of [['#ffffffcc', width + 2.5], [colour, width]]) {
    ctx.strokeStyle = style;
    ctx.lineWidth = wide;
    ctx.beginPath();
    path();
    ctx.stroke();
  }
}

function drawVectors(ctx, prism, view, kind, gain) {
  const range = errorRange(kind);
  if (!range) return;
  for (const corner of prism.corners) {
    const error = errorOf(corner, kind);
    if (!error || !(error.length > 0)) continue;
    const from = [view.x + corner[CORNER.x] * view.scale, view.y + corner[CORNER.y] * view.scale];
    const by = [error.x * gain * view.scale, error.y * gain * view.scale];
    const length = Math.hypot(...by);
    if (length < 0.7) continue;
    const to = [from[0] + by[0], from[1] + by[1]];
    const head = Math.min(7, length / 2);
    const wing = (turn) => [0, 1].map((k) => to[k] - head * (by[k] * Math.cos(turn) + (k ? 1 : -1) * by[1 - k] * Math.sin(turn)) / length);
    rimmed(ctx, () => {
      ctx.moveTo(...from);
      ctx.lineTo(...to);
      ctx.moveTo(...wing(0.45));
      ctx.lineTo(...to);
      ctx.lineTo(...wing(-0.45));
    }, errorColour(error.length, range), 1.6);
  }
}

function drawCorners(ctx, prism, view, chosen) {
  for (const corner of prism.corners) {
    const at = [view.x + corner[CORNER.x] * view.scale, view.y + corner[CORNER.y] * view.scale];
    const radius = corner === chosen ? 7 : Math.min(5, 1.5 + view.scale * 1.5);
    rimmed(ctx, () => ctx.arc(at[0], at[1], radius, 0, 2 * Math.PI), corner === chosen ? '#d4000f' : '#0b5cad', corner === chosen ? 2.5 : 1.2);
  }
}

function drawLine(ctx, view, points, colour, dash) {
  ctx.setLineDash(dash);
  rimmed(ctx, () => points.forEach((p, k) => ctx[k ? 'lineTo' : 'moveTo'](view.x + p.x * view.scale, view.y + p.y * view.scale)), colour, 2);
  ctx.setLineDash([]);
}
