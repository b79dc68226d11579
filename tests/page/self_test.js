// Uses a page of a comparison as a person does, and says what went wrong. It is put behind the page's own scripts.
(function selfTest() {
  const failures = [];
  const check = (what, holds, seen) => { if (!holds) failures.push(`${what}: ${JSON.stringify(seen)}`); };
  window.addEventListener('error', (event) => failures.push(`error: ${event.message}`));

  const box = () => { const all = canvas.getBoundingClientRect(); return { left: all.left + canvas.clientLeft, top: all.top + canvas.clientTop }; };
  const send = (kind, x, y, more = {}) => canvas.dispatchEvent(new PointerEvent(kind, {
    clientX: box().left + x, clientY: box().top + y, bubbles: true, cancelable: true, pointerId: 1, ...more }));
  const press = (key) => canvas.dispatchEvent(new KeyboardEvent('keydown', { key, bubbles: true, cancelable: true }));
  const choose = (id, value) => {
    const element = document.getElementById(id);
    if (element.type === 'checkbox') element.checked = value; else element.value = value;
    element.dispatchEvent(new Event('change', { bubbles: true }));
  };
  const mode = (value) => {
    const input = document.querySelector(`input[name=mode][value=${value}]`);
    input.checked = true;
    input.dispatchEvent(new Event('change', { bubbles: true }));
  };
  const reader = new OffscreenCanvas(1, 1).getContext('2d', { willReadFrequently: true });
  const read = (x, y, width, height) => {
    [reader.canvas.width, reader.canvas.height] = [canvas.width, canvas.height];
    reader.drawImage(canvas, 0, 0);
    return reader.getImageData(x, y, width, height).data;
  };
  const pixels = () => read(0, 0, canvas.width, canvas.height);
  const hash = () => pixels().reduce((sum, value, k) => (sum + value * (k % 9973 + 1)) % 2147483647, 0);
  const colours = () => { const all = new Set(); const data = pixels(); for (let k = 0; k < data.length; k += 4) all.add((data[k] << 16) | (data[k + 1] << 8) | data[k + 2]); return all; };

  function zoomAndPan() {
    const [clientX, clientY] = [Math.round(box().left + 300), Math.round(box().top + 200)];
    const at = { x: clientX - box().left, y: clientY - box().top };
    const px = toPicture(at.x, at.y);
    const before = { ...state.view };
    canvas.dispatchEvent(new WheelEvent('wheel', { clientX, clientY, deltaY: -900, bubbles: true, cancelable: true }));
    const after = toWindow(px.x, px.y);
    check('the wheel zooms', state.view.scale > 2 * before.scale, state.view);
    check('the place under the pointer stays', Math.hypot(after.x - at.x, after.y - at.y) < 1e-6, [at, after]);

    // At a large zoom every pixel is a square of one level.
    choose('show-corners', false);
    state.view = { x: 7 - 100 * 32, y: 5 - 60 * 32, scale: 32 };
    draw();
    const ratio = devicePixelRatio;
    const one = read((7 + 2) * ratio, (5 + 2) * ratio, 28 * ratio, 28 * ratio);
    check('pixels are crisp', one.every((value, k) => value === one[k % 4]), [...one.slice(0, 8)]);

    send('pointerdown', 100, 100);
    send('pointermove', 140, 90);
    send('pointerup', 140, 90);
    check('a drag moves the picture', state.view.x === 7 - 100 * 32 + 40 && state.view.y === 5 - 60 * 32 - 10, state.view);
    press('0');
    const right = toWindow(prisms[0].size[0], prisms[0].size[1]);
    check('0 shows all', right.x <= canvas.clientWidth && right.y <= canvas.clientHeight && state.view.x >= 0, state.view);
    press('+');
    check('plus zooms', state.view.scale > 0, state.view);
    press('0');
    choose('show-corners', true);
  }

  function corners() {
    const prism = prisms[state.a];
    const corner = prism.corners[Math.floor(prism.corners.length / 3)];
    const at = toWindow(corner[3], corner[4]);
    send('pointermove', at.x + 1, at.y - 1);
    const words = () => document.getElementById('corner').textContent;
    check('a corner is told on hover', words().includes(`column ${corner[1]}, row ${corner[2]}`) && words().includes('found − true'), words());
    check('its covariance too', words().includes('standard deviation') && corner[9] > 0, corner);
    press('n');
    check('n steps to the next', state.corner === prism.corners[Math.floor(prism.corners.length / 3) + 1], state.corner);
    press('p');
    check('p steps back', state.corner === corner, state.corner);
  }

  function overlays() {
    for (const id of ['show-vectors', 'show-heat']) {
      const before = hash();
      choose(id, true);
      check(`${id} draws`, hash() !== before, id);
      check(`${id} has a legend`, document.querySelector('#legend .ticks') !== null, id);
      choose(id, false);
      check(`${id} goes away`, hash() === before, id);
    }
    choose('gain', '10');
    check('the gain is taken', state.gain === 10, state.gain);
  }

  function modes() {
    if (prisms.length < 2) return;
    choose('show-corners', false);
    const [first] = [hash(), mode('one')];
    choose('prism-a', '1');
    const second = hash();
    choose('prism-a', '0');
    check('two prisms differ', first !== second, [first, second]);
    mode('difference');
    check('a difference is coloured', [...colours()].some((c) => (c >> 16) - (c & 255) > 60), colours().size);
    mode('slider');
    const half = hash();
    const slider = document.getElementById('slider');
    slider.value = 100;
    slider.dispatchEvent(new Event('input', { bubbles: true }));
    check('the slider moves', hash() !== half && Math.abs(state.split - 0.1) < 1e-9, state.split);
    mode('blink');
    state.blinkOn = true;
    draw();
    check('blink shows the other', hash() === second, [hash(), second]);
    mode('one');
    choose('show-corners', true);
  }

  function epipolar() {
    const prism = prisms[0];
    const at = toWindow(0.31 * prism.size[0], 0.27 * prism.size[1]);
    send('pointerdown', at.x, at.y);
    send('pointerup', at.x, at.y);
    const lines = epipolarLines(prism, state.pixel.x, state.pixel.y);
    check('a click chooses the pixel', state.lines && Math.abs(state.pixel.x - 0.31 * prism.size[0]) < 1, state.pixel);
    check('its match lies in the other half', lines && halfOf(prism, lines.match.x, lines.match.y) === 1 - lines.half, lines && lines.match);
    check('the line runs over depth', lines.other.length > 20 && Math.abs(lines.other[0].x - lines.other[60].x) > 2, lines.other.length);

    // A corner's match at the board is the same corner of the other half.
    const found = prism.corners.find((c) => c[0] === 0 && prism.corners.some((d) => d[0] === 1 && d[1] === c[1] && d[2] === c[2]));
    const twin = prism.corners.find((d) => d[0] === 1 && d[1] === found[1] && d[2] === found[2]);
    const match = otherPixel(prism, 0, found[3], found[4], prism.board_mm);
    check('a corner matches its twin', Math.hypot(match.x - twin[3], match.y - twin[4]) < 0.02, [match, twin.slice(0, 5)]);
    check('a curve is drawn', document.querySelector('#curve-depth canvas') !== null, 'curve');
  }

  function access() {
    const unnamed = [...document.querySelectorAll('button, select, input')].filter((control) =>
      !control.getAttribute('aria-label') && !control.textContent.trim() && !control.labels?.length);
    check('every control has a name', !unnamed.length, unnamed.map((c) => c.id));
    const unreachable = [...document.querySelectorAll('button, select, input, canvas#canvas, .term')].filter((c) => c.tabIndex < 0);
    check('every control can be reached', !unreachable.length, unreachable.map((c) => c.id));
    const heads = [...document.querySelectorAll('h1, h2, h3')].map((h) => Number(h.tagName[1]));
    check('headings step down one at a time', heads.every((level, k) => !k || level <= heads[k - 1] + 1), heads);
    const term = document.querySelector('#figures .term');
    term.focus();
    check('a definition is told on focus', !document.getElementById('word').hidden && document.getElementById('word').textContent.includes('Source'), document.getElementById('word').textContent);
    term.blur();
    document.querySelectorAll('.term').forEach((t) => check('every term is explained', t.dataset.word, t.textContent));
  }

  // Relative luminance and contrast of WCAG 2.1.
  function contrast() {
    const light = (name) => {
      const hex = styleValue(name);
      const part = (k) => parseInt(hex.slice(1 + 2 * k, 3 + 2 * k), 16) / 255;
      const linear = (v) => (v <= 0.03928 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);
      return 0.2126 * linear(part(0)) + 0.7152 * linear(part(1)) + 0.0722 * linear(part(2));
    };
    const pairs = [['--ink', '--paper'], ['--ink', '--panel'], ['--quiet', '--paper'], ['--quiet', '--panel'], ['--accent', '--paper'],
      ['--good', '--good-paper'], ['--other', '--other-paper']];
    for (const [ink, paper] of pairs) {
      const [a, b] = [light(ink), light(paper)];
      const ratio = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
      check(`contrast of ${ink} on ${paper}`, ratio >= 4.5, ratio);
    }
  }

  function finish() {
    const requests = performance.getEntriesByType('resource').filter((entry) => !entry.name.startsWith('data:'));
    check('nothing is fetched', !requests.length, requests.map((entry) => entry.name));
    const result = document.createElement('pre');
    result.id = 'self-test';
    result.textContent = failures.length ? `FAILED ${failures.join(' | ')}` : `passed ${darkPaper.matches ? 'dark' : 'light'}`;
    document.body.append(result);
  }

  function start() {
    if (document.documentElement.dataset.ready !== 'yes') return setTimeout(start, 20);
    for (const part of [zoomAndPan, corners, overlays, modes, epipolar, access, contrast]) {
      try { part(); } catch (error) { failures.push(`${part.name}: ${error.stack}`); }
    }
    return finish();
  }
  start();
})();
