// The charts of costs: marks by knob, and the front of those that no other beats.
pageData.charts.forEach((chart, k) => {
  document.getElementById(`chart-title-${k}`).textContent = chart.title;
  const element = document.getElementById(`chart-${k}`);
  const reading = document.getElementById(`chart-reading-${k}`);
  const front = chart.front.length ? [{ name: 'no other beats', points: chart.front, band: true }] : [];
  const named = chart.series.map(([name, marks], colour) =>
    ({ name, points: marks, marks: true, line: marks.length > 1, colour }));
  const plot = drawChart(element, { x: { label: chart.x, log: true }, y: { label: chart.y, log: true } }, [...front, ...named]);

  // Read the mark nearest to the pointer, or step through them.
  const marks = chart.series.flatMap(([, all]) => all).sort((p, q) => p[0] - q[0]);
  let chosen = -1;
  const tell = () => {
    const [time, error, label] = marks[chosen];
    reading.textContent = `${label}: ${readable(time)} ms, ${readable(error)} ${chart.y.endsWith('mm') ? 'mm' : 'px'}`;
  };
  element.addEventListener('pointermove', (event) => {
    if (!element.plot) return;
    const box = element.plot.over.getBoundingClientRect();
    const far = ([x, y]) => Math.hypot(element.plot.valToPos(x, 'x') - (event.clientX - box.left),
      element.plot.valToPos(y, 'y') - (event.clientY - box.top));
    const nearest = marks.reduce((best, mark, m) => (best < 0 || far(mark) < far(marks[best]) ? m : best), -1);
    if (nearest >= 0 && far(marks[nearest]) < 24) { chosen = nearest; tell(); }
  });
  element.addEventListener('keydown', (event) => {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!step) return;
    event.preventDefault();
    chosen = (chosen + step + marks.length) % marks.length;
    tell();
  });
});
