// What a person does: pointer, keys and controls; and the words beside the picture.
const byId = (id) => document.getElementById(id);

function tableOf(rows) {
  const table = document.createElement('table');
  for (const [name, ...values] of rows) {
    const row = table.insertRow();
    const head = document.createElement('th');
    head.scope = 'row';
    head.textContent = name;
    row.append(head);
    for (const value of values) {
      const cell = row.insertCell();
      cell.className = 'number';
      cell.textContent = value;
    }
  }
  return table;
}

function headed(text, ...under) {
  const heading = document.createElement('h3');
  heading.textContent = text;
  return [heading, ...under];
}

// What is known of a corner.
function tellCorner(corner) {
  const prism = prisms.find((one) => one.corners.includes(corner));
  const vector = (at) => (corner[at] === null || corner[at] === undefined ? null : [readable(corner[at]), readable(corner[at + 1])]);
  const place = (at) => (corner[at] === null ? ['-', '-'] : [0, 1].map((k) => (corner[CORNER.x + k] - corner[at + k]).toFixed(4)));
  const rows = [
    ['', 'x, px', 'y, px'],
    ['found', corner[CORNER.x].toFixed(4), corner[CORNER.y].toFixed(4)],
    ['true', ...place(CORNER.isTrue)],
    ['ideal', ...place(CORNER.ideal)],
    ['found − true', ...(vector(CORNER.isTrue) ?? ['-', '-'])],
    ['found − ideal', ...(vector(CORNER.ideal) ?? ['-', '-'])],
    ['standard deviation', ...(vector(CORNER.spread) ?? ['-', '-'])],
  ];
  const rho = corner[CORNER.spread + 2];
  if (rho !== null && rho !== undefined) rows.push(['correlation', readable(rho), '']);
  pageData.budget_steps.forEach((step, k) => {
    const values = vector(CORNER.steps + 2 * k);
    if (values) rows.push([`budget: ${step}`, ...values]);
  });
  const half = ['left', 'right'][corner[CORNER.half]];
  byId('corner').replaceChildren(
    ...headed(`${prism.name}, ${half} half, column ${corner[CORNER.column]}, row ${corner[CORNER.row]}`, tableOf(rows)));
}

// What is known of the chosen pixel.
function tellPixel() {
  const { x, y } = state.pixel;
  const rows = [['', 'match x', 'match y', 'Δy, px']];
  for (const prism of prisms) {
    const lines = epipolarLines(prism, x, y);
    if (lines) rows.push([prism.name, lines.match.x.toFixed(3), lines.match.y.toFixed(3), readable(lines.match.dy)]);
  }
  const words = rows.length > 1 ? tableOf(rows) : document.createTextNode('No half sees it.');
  byId('corner').replaceChildren(...headed(`pixel (${x.toFixed(2)}, ${y.toFixed(2)}), its match at the depth of the board`, words));
}

function choosePixel(x, y) {
  state.pixel = { x, y };
  state.lines = true;
  byId('show-lines').checked = true;
  tellPixel();
  drawDepthCurve();
  draw();
}

function chooseCorner(corner) {
  state.corner = corner;
  if (corner) tellCorner(corner);
  draw();
}

// The next corner, or the one before, in the order of half, column and row; brought into view.
function stepCorner(by) {
  const all = shownPrism().corners;
  if (!all.length) return;
  const at = all.indexOf(state.corner);
  const next = all[(at + by + all.length + (at < 0 && by < 0 ? 1 : 0)) % all.length];
  const place = toWindow(next[CORNER.x], next[CORNER.y]);
  const [w, h] = [canvas.clientWidth, canvas.clientHeight];
  if (place.x < 0 || place.x > w || place.y < 0 || place.y > h) {
    state.view.x += w / 2 - place.x;
    state.view.y += h / 2 - place.y;
  }
  chooseCorner(next);
}

function legend() {
  const range = state.vectors || state.heat ? errorRange(state.kind) : null;
  const box = byId('legend');
  box.replaceChildren();
  if (!range) return;
  const ramp = document.createElement('div');
  ramp.className = 'ramp';
  ramp.style.background = `linear-gradient(to right, ${RAMP.join(', ')})`;
  const ticks = document.createElement('div');
  ticks.className = 'ticks';
  for (const [k, value] of [range.low, Math.sqrt(range.low * range.high), range.high].entries()) {
    const tick = document.createElement('span');
    tick.textContent = (k === 0 && range.clipped ? '≤ ' : '') + readable(value);
    ticks.append(tick);
  }
  box.append(...headed('length of the error, px'), ramp, ticks);
}

function pictureNote() {
  const notes = [...new Set([state.a, state.b])].flatMap((k) => {
    const { name, picture } = prisms[k];
    if (!picture) return [];
    const quality = picture.jpeg_quality ? [`${name}: shown as a JPEG of quality ${picture.jpeg_quality}, which is not exact`] : [];
    return picture.step > 1 ? [...quality, `${name}: ${picture.step} x ${picture.step} pixels are shown as one`] : quality;
  });
  const [first, second] = [prisms[state.a].name, prisms[state.b].name];
  if (state.mode === 'difference') notes.push(sameSize() ? `Vermilion: ${first} is brighter; blue: ${second} is.` : 'The pictures differ in size, and have no difference.');
  if (state.mode === 'slider') notes.push(`Left of the line: ${first}; right of it: ${second}`);
  byId('picture-note').textContent = notes.join('. ');
}

// Errors that no corner here has cannot be chosen.
function disableUnknown() {
  for (const option of byId('error-kind').options) {
    option.disabled = !prisms.some((prism) => prism.corners.some((corner) => errorOf(corner, option.value)));
  }
  const known = [...byId('error-kind').options].find((option) => !option.disabled);
  if (known) { known.selected = true; state.kind = known.value; }
}

// The gain by which the longest error is drawn some 60 px long.
function fillGains() {
  const range = errorRange(state.kind);
  const exponent = range ? Math.max(0, Math.floor(Math.log10(60 / range.high))) : 1;
  state.gain = 10 ** exponent;
  byId('gain').replaceChildren(...Array.from({ length: 9 }, (_, k) => new Option(`${readable(10 ** k)} ×`, 10 ** k, false, k === exponent)));
}

function refresh() {
  if (byId('slider-label')) byId('slider-label').hidden = state.mode !== 'slider';
  legend();
  pictureNote();
  draw();
}

// The place of an event in px of the canvas, without its border.
function placeOf(event) {
  const box = canvas.getBoundingClientRect();
  return { x: event.clientX - box.left - canvas.clientLeft, y: event.clientY - box.top - canvas.clientTop };
}

function pointerControls() {
  let drag = null;
  canvas.addEventListener('wheel', (event) => {
    event.preventDefault();
    const at = placeOf(event);
    zoom(Math.exp(-event.deltaY * 0.0015), at.x, at.y);
    draw();
  }, { passive: false });
  canvas.addEventListener('pointerdown', (event) => {
    const at = placeOf(event);
    const onSlider = state.mode === 'slider' && Math.abs(at.x - state.split * canvas.clientWidth) < 8;
    drag = { ...at, view: { ...state.view }, moved: false, onSlider };
    try { canvas.setPointerCapture(event.pointerId); } catch { /* a pointer that has left */ }
  });
  canvas.addEventListener('pointermove', (event) => {
    const at = placeOf(event);
    const px = toPicture(at.x, at.y);
    byId('place').textContent = `x ${px.x.toFixed(2)}, y ${px.y.toFixed(2)} px, ${readable(state.view.scale)} ×`;
    if (!drag) {
      const corner = cornerAt(at.x, at.y);
      if (corner && corner !== state.corner) chooseCorner(corner);
      return;
    }
    drag.moved ||= Math.hypot(at.x - drag.x, at.y - drag.y) > 3;
    if (drag.onSlider) {
      setSplit(at.x / canvas.clientWidth);
    } else if (drag.moved) {
      state.view = { ...drag.view, x: drag.view.x + at.x - drag.x, y: drag.view.y + at.y - drag.y };
      draw();
    }
  });
  canvas.addEventListener('pointerup', () => {
    if (drag && !drag.moved && !drag.onSlider) { const px = toPicture(drag.x, drag.y); choosePixel(px.x, px.y); }
    drag = null;
  });
  canvas.addEventListener('pointercancel', () => { drag = null; });
}

function setSplit(share) {
  state.split = Math.min(Math.max(share, 0), 1);
  byId('slider').value = Math.round(1000 * state.split);
  draw();
}

function keyControls() {
  const middle = () => [canvas.clientWidth / 2, canvas.clientHeight / 2];
  const keys = {
    '+': () => zoom(1.25, ...middle()), '=': () => zoom(1.25, ...middle()), '-': () => zoom(0.8, ...middle()),
    0: fit, 1: () => zoom(1 / state.view.scale, ...middle()),
    ArrowLeft: () => { state.view.x += 60; }, ArrowRight: () => { state.view.x -= 60; },
    ArrowUp: () => { state.view.y += 60; }, ArrowDown: () => { state.view.y -= 60; },
    n: () => stepCorner(1), p: () => stepCorner(-1),
    Enter: () => {
      const px = state.corner ? { x: state.corner[CORNER.x], y: state.corner[CORNER.y] } : toPicture(...middle());
      choosePixel(px.x, px.y);
    },
  };
  canvas.addEventListener('keydown', (event) => {
    const act = keys[event.key];
    if (!act || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    act();
    draw();
  });
}

function barControls() {
  const on = (id, kind, act) => byId(id)?.addEventListener(kind, (event) => { act(event.target); refresh(); });
  const other = () => { state.corner = null; };
  on('prism-a', 'change', (e) => { state.a = Number(e.value); other(); });
  on('prism-b', 'change', (e) => { state.b = Number(e.value); other(); });
  on('modes', 'change', (e) => { state.mode = e.value; state.blinkOn = false; });
  byId('slider')?.addEventListener('input', (event) => setSplit(event.target.value / 1000));
  for (const [id, key] of [['show-corners', 'corners'], ['show-vectors', 'vectors'], ['show-heat', 'heat'], ['show-lines', 'lines']]) {
    on(id, 'change', (e) => {
      state[key] = e.checked;
      if (key === 'lines' && e.checked && !state.pixel) choosePixel(prisms[state.a].size[0] / 4, prisms[state.a].size[1] / 4);
    });
  }
  on('error-kind', 'change', (e) => { state.kind = e.value; fillGains(); drawErrorCurves(); });
  on('gain', 'change', (e) => { state.gain = Number(e.value); });
  on('zoom-in', 'click', () => zoom(1.25, canvas.clientWidth / 2, canvas.clientHeight / 2));
  on('zoom-out', 'click', () => zoom(0.8, canvas.clientWidth / 2, canvas.clientHeight / 2));
  on('zoom-fit', 'click', fit);
  on('zoom-one', 'click', () => zoom(1 / state.view.scale, canvas.clientWidth / 2, canvas.clientHeight / 2));
  setInterval(() => { if (state.mode === 'blink') { state.blinkOn = !state.blinkOn; draw(); } }, 700);
}
