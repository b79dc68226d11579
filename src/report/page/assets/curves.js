// The curves below the pictures, and the start of it all.
function drawDepthCurve() {
  const { x, y } = state.pixel;
  const series = prisms.flatMap((prism, colour) => {
    const lines = epipolarLines(prism, x, y);
    return lines ? [{ name: prism.name, colour, points: lines.other.map((p) => [p.depth, Math.abs(p.dy)]) }] : [];
  });
  byId('curve-title-depth').textContent =
    `Epipolar line of the pixel (${x.toFixed(1)}, ${y.toFixed(1)}): how far it is from its row, over depth`;
  drawChart(byId('curve-depth'), { x: { label: 'depth, mm', log: true }, y: { label: '|y − y of its row|, px', log: true } }, series);
}

function drawErrorCurves() {
  const lengths = (prism) => prism.corners.flatMap((corner) => {
    const error = errorOf(corner, state.kind);
    return error ? [{ x: corner[CORNER.x], length: error.length }] : [];
  });
  const share = prisms.map((prism, colour) => {
    const all = lengths(prism).map((e) => e.length).sort((a, b) => a - b);
    return { name: prism.name, colour, points: all.map((length, k) => [length, 100 * (k + 1) / all.length]) };
  });
  drawChart(byId('curve-share'), { x: { label: 'length of the error, px', log: true }, y: { label: 'corners, %' } }, share);

  const column = prisms.map((prism, colour) => {
    const bins = new Map();
    for (const { x, length } of lengths(prism)) {
      const bin = Math.floor(24 * x / prism.size[0]);
      bins.set(bin, [...(bins.get(bin) ?? []), length]);
    }
    const mean = (all) => all.reduce((a, b) => a + b, 0) / all.length;
    return { name: prism.name, colour, marks: true, points: [...bins].map(([bin, all]) => [(bin + 0.5) * prism.size[0] / 24, mean(all)]) };
  });
  drawChart(byId('curve-column'), { x: { label: 'x in the picture, px' }, y: { label: 'mean error, px', log: true } }, column);
}

disableUnknown();
fillGains();
pointerControls();
keyControls();
barControls();
loadPictures(() => {
  fit();
  state.pixel = { x: prisms[0].size[0] / 8, y: prisms[0].size[1] / 8 };
  drawDepthCurve();
  drawErrorCurves();
  refresh();
  new ResizeObserver(() => { draw(); }).observe(canvas);
  darkPaper.addEventListener('change', refresh);
  document.documentElement.dataset.ready = 'yes';
});
