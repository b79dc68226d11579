// The viewer: which pictures are shown and how, where the view is, and what is drawn.
const canvas = document.getElementById('canvas');
const prisms = pageData.prisms;
const state = {
  a: 0, b: Math.min(1, prisms.length - 1), mode: 'one', split: 0.5, blinkOn: false,
  view: { x: 0, y: 0, scale: 1 }, corner: null, pixel: null,
  corners: true, vectors: false, heat: false, lines: false, kind: 'ideal', gain: 10,
};
const images = prisms.map(() => null);
let differenceOf = null;

// The prism that is shown, or of the two beside the slider that at `x` of the window.
function shownPrism(x = 0) {
  const second = state.mode === 'blink' ? state.blinkOn : state.mode === 'slider' && x > state.split * canvas.clientWidth;
  return prisms[second ? state.b : state.a];
}

// Pictures become canvases when they have been read.
function loadPictures(done) {
  let waiting = prisms.length;
  const next = () => { waiting -= 1; if (!waiting) done(); };
  prisms.forEach((prism, k) => {
    if (!prism.picture) return next();
    const image = new Image();
    image.onload = () => { images[k] = image; next(); };
    image.onerror = next;
    image.src = prism.picture.address;
  });
}

// The difference of two pictures: vermilion where the first is brighter, blue where the second is.
function difference(a, b) {
  if (differenceOf && differenceOf.a === a && differenceOf.b === b) return differenceOf.picture;
  const [width, height] = [images[a].width, images[a].height];
  const levels = [a, b].map((k) => {
    const own = new OffscreenCanvas(width, height).getContext('2d', { willReadFrequently: true });
    own.drawImage(images[k], 0, 0, width, height);
    return own.getImageData(0, 0, width, height).data;
  });
  const out = new ImageData(width, height);
  for (let k = 0; k < out.data.length; k += 4) {
    const by = (levels[0][k] - levels[1][k]) / 255;
    const paint = by > 0 ? [196, 79, 0] : [0, 90, 180];
    const share = Math.abs(by);
    for (let c = 0; c < 3; c += 1) out.data[k + c] = 244 + (paint[c] - 244) * share;
    out.data[k + 3] = 255;
  }
  const picture = new OffscreenCanvas(width, height);
  picture.getContext('2d').putImageData(out, 0, 0);
  differenceOf = { a, b, picture };
  return picture;
}

const sameSize = () => prisms[state.a].size[0] === prisms[state.b].size[0] && prisms[state.a].size[1] === prisms[state.b].size[1];

// Draws no more than what lies from `from` to `to` of the width of the window.
function within(ctx, from, to, paint) {
  ctx.save();
  ctx.beginPath();
  ctx.rect(from, 0, to - from, canvas.clientHeight);
  ctx.clip();
  paint();
  ctx.restore();
}

// A picture in its place, or its border where there is none.
function drawPicture(ctx, picture, size) {
  const { view } = state;
  ctx.imageSmoothingEnabled = view.scale * devicePixelRatio < 1;
  ctx.imageSmoothingQuality = 'high';
  if (picture) {
    ctx.drawImage(picture, view.x, view.y, size[0] * view.scale, size[1] * view.scale);
  } else {
    ctx.strokeStyle = styleValue('--quiet');
    ctx.strokeRect(view.x, view.y, size[0] * view.scale, size[1] * view.scale);
  }
}

// A prism's picture with what is asked for over it.
function drawPrism(ctx, prism) {
  const k = prisms.indexOf(prism);
  const both = state.mode === 'difference' && sameSize() && images[state.a] && images[state.b];
  drawPicture(ctx, both ? difference(state.a, state.b) : images[k], prism.size);
  if (state.heat) drawHeat(ctx, prism, state.view, state.kind);
  if (state.vectors) drawVectors(ctx, prism, state.view, state.kind, state.gain);
  if (state.corners) drawCorners(ctx, prism, state.view, state.corner);
}

function drawPrisms(ctx) {
  const width = canvas.clientWidth;
  if (state.mode !== 'slider') return drawPrism(ctx, shownPrism());
  const at = state.split * width;
  within(ctx, 0, at, () => drawPrism(ctx, prisms[state.a]));
  within(ctx, at, width, () => drawPrism(ctx, prisms[state.b]));
  return rimmed(ctx, () => { ctx.moveTo(at, 0); ctx.lineTo(at, canvas.clientHeight); }, '#d4000f', 2);
}

function drawEpipolar(ctx) {
  if (!state.lines || !state.pixel) return;
  const told = state.mode === 'one' ? [state.a] : [...new Set([state.a, state.b])];
  const { view, pixel } = state;
  const end = prisms[state.a].size[0];
  drawLine(ctx, view, [{ x: 0, y: pixel.y }, { x: end, y: pixel.y }], '#666666', [3, 5]);
  for (const k of told) {
    const lines = epipolarLines(prisms[k], pixel.x, pixel.y);
    if (!lines) continue;
    const colour = SERIES_COLOURS[0][k % SERIES_COLOURS[0].length];
    drawLine(ctx, view, lines.other, colour, []);
    drawLine(ctx, view, lines.own, colour, []);
    rimmed(ctx, () => ctx.arc(view.x + lines.match.x * view.scale, view.y + lines.match.y * view.scale, 5, 0, 2 * Math.PI), colour, 2);
  }
  rimmed(ctx, () => {
    const [x, y] = [view.x + pixel.x * view.scale, view.y + pixel.y * view.scale];
    ctx.moveTo(x - 9, y); ctx.lineTo(x + 9, y); ctx.moveTo(x, y - 9); ctx.lineTo(x, y + 9);
  }, '#d4000f', 2);
}

function draw() {
  const ratio = devicePixelRatio;
  const [width, height] = [canvas.clientWidth, canvas.clientHeight];
  if (canvas.width !== Math.round(width * ratio)) canvas.width = Math.round(width * ratio);
  if (canvas.height !== Math.round(height * ratio)) canvas.height = Math.round(height * ratio);
  const ctx = canvas.getContext('2d');
  ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
  ctx.clearRect(0, 0, width, height);
  drawPrisms(ctx);
  drawEpipolar(ctx);
}

// All of the picture, with room for vectors that leave it.
function fit() {
  const [w, h] = prisms[state.a].size;
  const scale = 0.94 * Math.min(canvas.clientWidth / w, canvas.clientHeight / h);
  state.view = { scale, x: (canvas.clientWidth - w * scale) / 2, y: (canvas.clientHeight - h * scale) / 2 };
}

// `factor` times as large, the place (x, y) of the window unmoved.
function zoom(factor, x, y) {
  const scale = Math.min(Math.max(state.view.scale * factor, 0.02), 64);
  const by = scale / state.view.scale;
  state.view = { scale, x: x - (x - state.view.x) * by, y: y - (y - state.view.y) * by };
}

const toPicture = (x, y) => ({ x: (x - state.view.x) / state.view.scale, y: (y - state.view.y) / state.view.scale });
const toWindow = (x, y) => ({ x: state.view.x + x * state.view.scale, y: state.view.y + y * state.view.scale });

// The corner nearest to a place of the window, within 14 px of it.
function cornerAt(x, y) {
  let [best, least] = [null, 14];
  for (const corner of shownPrism(x).corners) {
    const at = toWindow(corner[CORNER.x], corner[CORNER.y]);
    const far = Math.hypot(at.x - x, at.y - y);
    if (far < least) [best, least] = [corner, far];
  }
  return best;
}
