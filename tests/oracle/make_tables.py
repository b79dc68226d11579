"""Tables of refraction and of whole traces, to 50 digits, by a program that shares no line with the simulator.

    pip install mpmath==1.3.0
    cargo run --release -- design scenes/paper.toml --out tests/oracle/made   # writes the prism.toml beside this script
    python3 tests/oracle/make_tables.py                                       # writes the *.csv beside this script

Ways differ from the simulator's on purpose: a refracted ray is built from its tangential part (which Snell's law scales)
and the root of what is left; a polynomial is summed term by term; the first crossing of a ray and a sheet is the least
real root of the polynomial that the ray makes of it. Inputs are the decimal numbers of the tables or, where a
table says so, the exact values of 64-bit floats.
"""

import os
import re
import struct
import sys

from mpmath import asin, atan, cos, mp, mpf, nstr, pi, polyroots, sin, sqrt, tan, workdps

mp.dps = 50
HERE = os.path.dirname(os.path.abspath(__file__))
DIGITS = 30


def text(x):
    return nstr(x, DIGITS, min_fixed=-3, max_fixed=6)


def write(name, about, columns, rows):
    with open(os.path.join(HERE, name), "w", newline="\n") as out:
        out.write("# made by: python3 tests/oracle/make_tables.py (mpmath %s, %d digits)\n" % (mp_version(), mp.dps))
        for line in about:
            out.write("# %s\n" % line)
        out.write(columns + "\n")
        for row in rows:
            out.write(",".join(x if isinstance(x, str) else text(x) for x in row) + "\n")


def mp_version():
    import mpmath
    return mpmath.__version__


def ulps(x, n):
    """The float n units in the last place after x."""
    return struct.unpack("<d", struct.pack("<q", struct.unpack("<q", struct.pack("<d", x))[0] + n))[0]


# ---------------------------------------------------------------- one refraction

def refraction_rows():
    """Incoming (x, 0, z) on the plane z = 0 as exact floats; the cosine of refraction, or `none`."""
    cases = []
    for eta in (1.0 + 2.0**-52, 1.0 + 2.0**-50, 1.0 + 1e-12, 1.0001, 1.1, 1.33, 1.48, 1.5168, 2.0, 4.0):
        critical = asin(1 / mpf(eta))
        for exponent in range(3, 17):
            for sign in (-1, 1):
                angle = critical + sign * mpf(10)**-exponent
                if 0 < angle < pi / 2:
                    cases.append((eta, float(sin(angle)), float(cos(angle))))
        s, c = float(sin(critical)), float(cos(critical))
        cases += [(eta, s, ulps(c, n)) for n in (-32, -3, -2, -1, 0, 1, 2, 3, 32)]
    for eta in (0.25, 1 / 1.48, 0.75, 0.9999, 1.0 - 2.0**-53, 1.0, 1.0 + 2.0**-52, 1.48):
        for c in (0.0, 1e-300, 1e-160, 1e-30, 1e-16, 1e-12, 1e-8, 1e-4, 1e-2, 0.5, 1.0 - 2.0**-53, 1.0):
            cases.append((eta, float(sqrt(1 - mpf(c)**2)), c))
    for eta, s, c in cases:
        # The cosine of incidence is z itself; Snell's law in sines of angles, with sin^2 = 1 - z^2. For a z of 1e-300 the
        # 50 digits of the result take 700 on the way.
        with workdps(700):
            square = 1 - mpf(eta)**2 * (1 - mpf(c)**2)
            cosine = sqrt(square) if square >= 0 else "none"
        yield repr(eta), repr(s), repr(c), cosine


# ---------------------------------------------------------------- whole traces

def refract(direction, gradient, index_in, index_out):
    """Unit direction after a surface of that normal direction; None beyond the critical angle."""
    length = sqrt(sum(g * g for g in gradient))
    n = [g / length for g in gradient]
    along = sum(a * b for a, b in zip(direction, n))
    tangential = [(a - along * b) * index_in / index_out for a, b in zip(direction, n)]
    left = 1 - sum(a * a for a in tangential)
    if left < 0:
        return None
    normal_part = sqrt(left) * (1 if along > 0 else -1)
    return [a + normal_part * b for a, b in zip(tangential, n)]


def unit(v):
    length = sqrt(sum(a * a for a in v))
    return [a / length for a in v]


class Camera:
    """A pinhole at the origin: 35 mm, 10.56 x 5.94 mm of sensor in w x h pixels."""

    def __init__(self, width=1920, height=1080):
        self.centre = (mpf(width) / 2, mpf(height) / 2)
        self.tangent = mpf("10.56") / width / 35

    def ray(self, x, y):
        return unit([(mpf(x) - self.centre[0]) * self.tangent, (mpf(y) - self.centre[1]) * self.tangent, mpf(1)])


def to_plane(point, direction, z):
    t = (z - point[2]) / direction[2]
    if t <= 0:
        return None
    return [p + t * d for p, d in zip(point, direction)]


def trace_flat(direction, index, outer, alpha, ridge, thickness, board):
    """From the origin through z = ridge + |x| tan(alpha) and the plane z = ridge + thickness to the plane z = board."""
    side = 1 if direction[0] >= 0 else -1
    slope = side * tan(alpha)
    t = ridge / (direction[2] - slope * direction[0])
    point = [t * d for d in direction]
    inside = refract(direction, [-slope, mpf(0), mpf(1)], outer, index)
    if inside is None:
        return "total_reflection", None, None
    point = to_plane(point, inside, ridge + thickness)
    if point is None:
        return "missed", None, None
    out = refract(inside, [mpf(0), mpf(0), mpf(1)], index, outer)
    if out is None:
        return "total_reflection", None, None
    point = to_plane(point, out, board)
    return ("board", point, out) if point else ("past_board", None, None)


def paper_alpha(index):
    """Eq. 5 of the design paper, corrected."""
    delta = atan(mpf("10.56") / 4 / 35)
    return atan(sin(delta) / (index - cos(delta)))


PIXELS = [("960", "540"), ("960.5", "540.5"), ("959.5", "539.5"), ("960.0000000001", "540"), ("959.9999999999", "540"),
          ("0", "0"), ("1920", "1080"), ("0", "1080"), ("1920", "0"), ("0.5", "0.5"), ("1919.5", "1079.5"),
          ("480", "540"), ("1440", "540"), ("480.25", "17.75"), ("1440.125", "1001.625"), ("1", "540"), ("1919", "540"),
          ("961", "3"), ("959", "1077"), ("1200.3", "270.7"), ("700.9", "800.1"), ("1800.01", "1000.99"),
          ("100.5", "100.5"), ("1000.5", "900.5"), ("1500.7", "33.3"), ("333.3", "666.6")]


def flat_rows():
    camera = Camera()
    for x, y in PIXELS:
        _, point, out = trace_flat(camera.ray(x, y), mpf("1.48"), mpf(1), paper_alpha(mpf("1.48")), mpf("78.472"),
                                   mpf("8.545"), mpf(1000))
        yield [x, y, point[0], point[1]] + out


def prism_rows():
    """Flat prisms from vanishing to extreme."""
    camera = Camera()
    pixels = [("960.5", "540.5"), ("1440", "300.25"), ("3.5", "1079.5"), ("1919.5", "0.5")]
    prisms = []
    for alpha in ["0.0"] + ["1e-%d" % e for e in (300, 160, 20, 16, 12, 8, 6, 4, 2, 1)]:
        prisms.append(("1.48", "1.0", alpha, "78.472", "8.545", "1000.0"))
    for index in ["1.0", "1.0000000000000002", "0.9999999999999999", "1.0000000000001", "0.999999999999", "1.00000001",
                  "1.0001", "0.9999", "4.0", "10.0", "0.5", "0.3", "0.2"]:
        prisms.append((index, "1.0", "8.85", "78.472", "8.545", "1000.0"))
    prisms += [("1.5", "1.333", "8.85", "78.472", "8.545", "1000.0"), ("1.0", "1.333", "8.85", "78.472", "8.545", "1000.0"),
               ("1.333", "1.333", "8.85", "78.472", "8.545", "1000.0"), ("1.5", "1.0", "-5.0", "78.472", "8.545", "1000.0"),
               ("1.5", "1.0", "40.0", "78.472", "60.0", "1000.0"), ("2.5", "1.0", "60.0", "78.472", "40.0", "1000.0")]
    for thickness in ["1e-12", "1e-9", "1e-6", "0.001", "1.0", "900.0"]:
        prisms.append(("1.48", "1.0", "0.0", "78.472", thickness, "1000.0"))
    for board in ["87.0170000001", "87.018", "100000.0", "1000000000.0", "1000000000000.0"]:
        prisms.append(("1.48", "1.0", "8.85", "78.472", "8.545", board))
    for ridge in ["0.000001", "0.01", "1000000.0"]:
        prisms.append(("1.48", "1.0", "1.0", ridge, "90000.0" if ridge == "1000000.0" else "8.545", "2000000.0"))
    for prism in prisms:
        index, outer, alpha, ridge, thickness, board = (mpf(v) for v in prism)
        for x, y in pixels:
            fate, point, _ = trace_flat(camera.ray(x, y), index, outer, alpha * pi / 180, ridge, thickness, board)
            yield list(prism) + [x, y, fate] + (point[:2] if point else ["", ""])


# ---------------------------------------------------------------- freeform

class Sheet:
    def __init__(self, terms, centre=(0, 0), scale=(1, 1)):
        self.terms, self.centre, self.scale = terms, centre, scale

    def value(self, x, y):
        u, v = (x - self.centre[0]) / self.scale[0], (y - self.centre[1]) / self.scale[1]
        return sum(c * u**m * v**n for m, n, c in self.terms)

    def gradient(self, x, y):
        u, v = (x - self.centre[0]) / self.scale[0], (y - self.centre[1]) / self.scale[1]
        dx = sum(c * m * u**(m - 1) * v**n for m, n, c in self.terms if m)
        dy = sum(c * n * u**m * v**(n - 1) for m, n, c in self.terms if n)
        return dx / self.scale[0], dy / self.scale[1]

    def normal(self, x, y):
        dx, dy = self.gradient(x, y)
        return [-dx, -dy, mpf(1)]

    def along(self, origin, direction):
        """The coefficients of the gap z(t) - sheet(x(t), y(t)) by rising powers of t."""
        def times(p, q):
            out = [mpf(0)] * (len(p) + len(q) - 1)
            for i, a in enumerate(p):
                for j, b in enumerate(q):
                    out[i + j] += a * b
            return out
        u = [(origin[0] - self.centre[0]) / self.scale[0], direction[0] / self.scale[0]]
        v = [(origin[1] - self.centre[1]) / self.scale[1], direction[1] / self.scale[1]]
        gap = [origin[2], direction[2]]
        for m, n, c in self.terms:
            term = [c]
            for factor in [u] * m + [v] * n:
                term = times(term, factor)
            gap += [mpf(0)] * (len(term) - len(gap))
            for i, a in enumerate(term):
                gap[i] -= a
        return gap

    def first(self, origin, direction, low, high):
        """The first crossing with t in [low, high]: the least real root of a polynomial in t; None without one."""
        gap = self.along(origin, direction)
        while gap and gap[-1] == 0:
            gap.pop()
        if len(gap) < 2:
            return None
        roots = polyroots(gap[::-1], maxsteps=2000, extraprec=2000)
        real = [r.real for r in roots if abs(r.imag) < mpf(10)**-30 * (1 + abs(r.real)) and low <= r.real <= high]
        return min(real) if real else None


def read_prism():
    """The two sheets of prism.toml."""
    sheets = []
    with open(os.path.join(HERE, "prism.toml")) as file:
        whole = file.read()
    for part in whole.split("[prism.")[1:]:
        numbers = lambda key: [mpf(v) for v in re.findall(r"[-+0-9.e]+", re.search(key + r" = (.*)", part).group(1))]
        terms = [(int(m), int(n), mpf(c)) for m, n, c in re.findall(r"^  \[(\d+), (\d+), (\S+)\],", part, re.M)]
        sheets.append(Sheet(terms, numbers("centre_mm"), numbers("scale_mm")))
    return sheets


def freeform_rows():
    camera = Camera()
    front, back = read_prism()
    origin, k = [mpf(0)] * 3, mpf("1.48")
    for x, y in PIXELS:
        direction = camera.ray(x, y)
        mirrored = direction[0] < 0
        d = [abs(direction[0]), direction[1], direction[2]]
        t = front.first(origin, d, mpf(70), mpf(95))
        p = [t * c for c in d]
        inside = refract(d, front.normal(p[0], p[1]), mpf(1), k)
        t = back.first(p, inside, mpf(0), mpf(15))
        q = [a + t * b for a, b in zip(p, inside)]
        out = refract(inside, back.normal(q[0], q[1]), k, mpf(1))
        board = to_plane(q, out, mpf(1000))
        if mirrored:
            board[0], out[0] = -board[0], -out[0]
        yield [x, y, board[0], board[1]] + out


def crossing_rows():
    """The first crossing of a ray and a wavy sheet over |x|, |y| <= 20. Rays and coefficients are exact floats."""
    sheets = {
        "valley": [(0, 0, 10.0), (2, 0, 1.0)],
        "wave": [(0, 0, 10.0), (1, 0, 3.0), (3, 0, -0.05), (5, 0, 0.0001)],
        "saddle": [(0, 0, 10.0), (2, 0, 0.05), (0, 2, -0.05), (1, 1, 0.03)],
        "degree15": [(0, 0, 10.0), (15, 0, 3e-19), (13, 2, -2e-19), (2, 0, 0.01), (1, 4, 1e-5), (7, 6, 1e-16)],
        "cancel": [(0, 0, 81000010.0), (2, 0, -18000000.0), (4, 0, 1000000.0), (0, 2, 0.01)],
    }
    rays = [((-6.0, 0.0, 19.0), (1.0, 0.0, 0.0)), ((-19.5, 1.0, 200.0), (0.8, 0.0, -0.6)),
            ((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)), ((0.0, 0.0, 0.0), (0.28, 0.0, 0.96)), ((1.0, -3.0, 0.0), (0.6, 0.0, 0.8)),
            ((-15.0, 2.0, 14.0), (0.96, 0.28, 0.0)), ((-19.0, -19.0, 20.0), (0.6, 0.64, -0.48)),
            ((0.0, 0.0, 50.0), (0.0, 0.0, -1.0)), ((3.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
            ((-6.0, 0.0, 10.0000000001), (1.0, 0.0, 0.0)), ((-6.0, 0.0, 9.9999999999), (1.0, 0.0, 0.0)),
            ((-6.0, 0.0, 10.000001), (1.0, 0.0, 0.0)), ((3.0, 0.0, 0.0), (0.0, 0.6, 0.8))]
    for name, terms in sheets.items():
        sheet = Sheet([(m, n, mpf(c)) for m, n, c in terms])
        for origin, direction in rays:
            o, d = [mpf(v) for v in origin], [mpf(v) for v in direction]
            low, high = mpf(0), mpf(10)**9
            for k in (0, 1):
                if d[k] == 0:
                    if abs(o[k]) > 20:
                        high = mpf(-1)
                else:
                    ends = sorted(((-20 - o[k]) / d[k], (20 - o[k]) / d[k]))
                    low, high = max(low, ends[0]), min(high, ends[1])
            t = sheet.first(o, d, low, high) if high > low else None
            slope = ""
            if t is not None:
                p = [a + t * b for a, b in zip(o, d)]
                dx, dy = sheet.gradient(p[0], p[1])
                slope = d[2] - dx * d[0] - dy * d[1]
            packed = " ".join("%d:%d:%r" % term for term in terms)
            yield [name, packed] + [repr(v) for v in origin + direction] + [t if t is not None else "missed", slope]


def main():
    write("refraction.csv", ["Refraction of the direction (in_x, 0, in_z) at the plane z = 0. Inputs are exact floats; the cosine",
                             "of incidence is in_z, and eta = n_in / n_out. cos_out is `none` beyond the critical angle."],
          "eta,in_x,in_z,cos_out", refraction_rows())
    write("flat.csv", ["The flat prism of the design paper (Eq. 5, corrected), 1920 x 1080 px, board at z = 1000 mm. Lengths in mm."],
          "x_px,y_px,u_mm,v_mm,out_x,out_y,out_z", flat_rows())
    write("prisms.csv", ["Flat prisms from vanishing to extreme, pinhole at the origin, 1920 x 1080 px. Lengths in mm, angle in deg."],
          "index,outer_index,alpha_deg,ridge_mm,thickness_mm,board_mm,x_px,y_px,fate,u_mm,v_mm", prism_rows())
    write("freeform.csv", ["The polynomial prism of prism.toml (biprism design scenes/paper.toml), 1920 x 1080 px, board at z = 1000 mm."],
          "x_px,y_px,u_mm,v_mm,out_x,out_y,out_z", freeform_rows())
    write("crossings.csv", ["The first crossing of a ray and z = sum c x^m y^n (terms m:n:c) over |x|, |y| <= 20, in mm, and the",
                            "speed d(gap)/dt there. Inputs are exact floats."],
          "sheet,terms,o_x,o_y,o_z,d_x,d_y,d_z,t_mm,speed", crossing_rows())


if __name__ == "__main__":
    sys.exit(main())
