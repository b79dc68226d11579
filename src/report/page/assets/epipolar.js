// Where the other half sees what a pixel sees, by the polynomials of a prism.
function chebyshev(x, n) {
  const values = [1, x];
  while (values.length <= n) values.push(2 * x * values[values.length - 1] - values[values.length - 2]);
  return values;
}

// Half of a pixel of the whole picture, 0 left and 1 right; -1 beside both.
function halfOf(prism, x, y) {
  const inside = (frame) => frame && x >= frame.first && x <= frame.first + frame.size[0] && y >= 0 && y <= frame.size[1];
  return prism.epipolar.findIndex(inside);
}

// The polynomial's place in the whole picture of what (x, y) sees at a depth in mm.
function otherPixel(prism, half, x, y, depth) {
  const p = prism.epipolar[half];
  const [near, far] = p.depths_mm.map((mm) => 1 / mm);
  const s = chebyshev((x - p.first) / p.size[0] * 2 - 1, 6);
  const t = chebyshev(y / p.size[1] * 2 - 1, 6);
  const w = chebyshev((2 / depth - near - far) / (near - far), 4);
  let [dx, dy] = [0, 0];
  p.terms.forEach(([i, j, k], n) => {
    const value = s[i] * t[j] * w[k];
    dx += p.x[n] * value;
    dy += p.y[n] * value;
  });
  return { x: x - p.first + dx + p.other_first, y: y + dy, dy, disparity: half === 0 ? -dx : dx };
}

// Depths evenly in their inverse, near to far.
function depthsOf(prism, half, count) {
  const [near, far] = prism.epipolar[half].depths_mm.map((mm) => 1 / mm);
  return Array.from({ length: count }, (_, k) => 1 / (near + (far - near) * k / (count - 1)));
}

// The line of a pixel in the other half, and that of its match at the board's depth in its own half.
function epipolarLines(prism, x, y) {
  const half = halfOf(prism, x, y);
  if (half < 0 || !prism.epipolar[half] || !prism.epipolar[1 - half]) return null;
  const at = depthsOf(prism, half, 61);
  const far = at.map((depth) => ({ depth, ...otherPixel(prism, half, x, y, depth) }));
  const match = otherPixel(prism, half, x, y, prism.board_mm);
  const own = at.map((depth) => ({ depth, ...otherPixel(prism, 1 - half, match.x, match.y, depth) }));
  return { half, other: far, own, match };
}
