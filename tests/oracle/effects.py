"""Pictures with many effects at once, and the ghosts of a wedge, by a program that shares no line with the simulator.

    pip install numpy
    python3 tests/oracle/effects.py     # writes effects.csv, ghosts.csv and ghosts_picture.csv beside this script

Ways differ from the simulator's on purpose. The glass is a convex body, three half-spaces: a ray enters through the last
of the planes that it meets from outside, and what is inside leaves through the first that it meets from inside. Polarised
light is a vector on which each surface acts by its s and p (Born & Wolf, Principles of Optics, 1.5.2). A pixel is filled
by slanting lines, along each of which the light is an integral in closed form, cut where it passes the ridge or a line of
the board, and for each line there is another point of the pupil; of ghosts a pixel is a mean of points. Only the scenes are
read; what their keys mean is in docs/scene.md.
"""

import math
import os
import sys
import tomllib

import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))
# Multiples of these, modulo 1, fill a cube: two of the pixel, two of the pupil; the latter are inverse powers of the root of
# x^3 = x + 1, which no fractions approach closely (roots of primes alone come near a resonance, which makes means ten times worse).
STEPS = (math.sqrt(2), math.sqrt(3), 1 / 1.3247179572447460, 1 / 1.3247179572447460**2)


# ---------------------------------------------------------------- vectors: arrays of shape (3, ...)

def dot(a, b):
    return (a * b).sum(0)


def cross(a, b):
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def unit(a):
    return a / np.sqrt(dot(a, a))


def column(v, like):
    """A constant vector beside an array of vectors."""
    return np.reshape(v, (3,) + (1,) * (like.ndim - 1))


def turned(angles_deg):
    """The matrix of a turn about the fixed x, then y, then z axis."""
    a, b, c = np.radians(angles_deg)
    x = np.array([[1, 0, 0], [0, math.cos(a), -math.sin(a)], [0, math.sin(a), math.cos(a)]])
    y = np.array([[math.cos(b), 0, math.sin(b)], [0, 1, 0], [-math.sin(b), 0, math.cos(b)]])
    z = np.array([[math.cos(c), -math.sin(c), 0], [math.sin(c), math.cos(c), 0], [0, 0, 1]])
    return z @ y @ x


# ---------------------------------------------------------------- one surface

def split(k, field, normal, n_in, n_out):
    """Unit directions and fields behind a surface and before it. `field` is a list of vectors across k whose squares are
    powers. Beyond the critical angle the cosine of refraction is imaginary, and nothing goes on."""
    normal = column(normal, k)
    across = dot(k, normal)
    n = normal * np.sign(across)                          # along the light
    cos_in = np.abs(across)
    along = k - cos_in * n                                # the tangential part, which Snell's law scales
    sine2 = dot(along, along) * (n_in / n_out)**2
    total = sine2 > 1
    cos_out = np.where(total, 1j, 1) * np.sqrt(np.abs(1 - sine2))
    refracted = n_in / n_out * along + cos_out.real * n
    reflected = k - 2 * cos_in * n
    # s lies across the plane of incidence; p = k x s goes round with the ray. Along the normal any s will do.
    s = cross(n, k)
    s = np.where(dot(s, s) > 1e-24, s, cross(k, column([0.0, 1.0, 0.0], k)))
    s = unit(s)
    a, b, c, d = n_in * cos_in, n_out * cos_out, n_out * cos_in, n_in * cos_out
    # Fresnel's amplitudes (Born & Wolf, 1.5.2, Eqs. 20 and 21), those of what goes on times the root of n cos / n' cos',
    # so that squares are powers.
    power = np.where(total, 0, np.sqrt(np.abs(b / a)))
    t_s, t_p = 2 * a / (a + b) * power, 2 * a / (c + d) * power
    r_s, r_p = (a - b) / (a + b), (c - d) / (c + d)
    parts = [(dot(e, s), dot(e, cross(k, s))) for e in field]
    on = [t_s * e_s * s + t_p * e_p * cross(refracted, s) for e_s, e_p in parts]
    back = [r_s * e_s * s + r_p * e_p * cross(reflected, s) for e_s, e_p in parts]
    return (refracted, on), (reflected, back)


def power(field):
    return sum(np.abs(dot(e, np.conj(e))) for e in field)


# ---------------------------------------------------------------- the scene

SELLMEIER = {  # Schott's data sheet: n^2 = 1 + sum B l^2 / (l^2 - C), l in um
    "N-SF11": ([1.73759695, 0.313747346, 1.89878101], [0.013188707, 0.0623068142, 155.23629]),
}


def catalogue(glass, nm):
    square = (nm / 1000)**2
    return math.sqrt(1 + sum(b * square / (square - c) for b, c in zip(*SELLMEIER[glass])))


class Bench:
    """What the scene says, in the world's frame."""

    def __init__(self, name, ghosts=True):
        with open(os.path.join(HERE, name), "rb") as file:
            scene = tomllib.load(file)
        camera, prism, self.board, effects = scene["camera"], scene["prism"], scene["board"], scene["effect"]
        self.eye = np.array(camera.get("position_mm", [0.0, 0.0, 0.0]))
        self.image = camera["focal_length_mm"]
        self.size, self.pitch = (camera["width_px"], camera["height_px"]), camera["pixel_pitch_um"] / 1000
        self.lens = effects.get("thin_lens")
        self.exponent = effects["cos4"].get("exponent", 4.0) if "cos4" in effects else 0.0
        self.ghosts = effects["ghosts"] if ghosts else None
        self.polarisation = effects["fresnel"].get("polarisation", "unpolarised")
        self.sensor, self.lamp = effects.get("sensor"), effects.get("lamp")
        self.active = math.sqrt(self.sensor["fill_factor"]) if self.sensor else 1.0
        # Catalogues give the transmittance of 10 mm (Beer and Lambert's law).
        self.per_mm = -math.log(effects["absorption"]["transmittance_10mm"]) / 10 if "absorption" in effects else 0.0
        # Of the catalogue only the change of the index is taken.
        self.lights = [(prism["index"], 1.0)]
        if "dispersion" in effects:
            lines, powers = effects["dispersion"]["lines_nm"], effects["dispersion"]["powers"]
            at = catalogue(prism["glass"], prism["wavelength_nm"])
            indices = [prism["index"] + catalogue(prism["glass"], line) - at for line in lines]
            self.lights = [(index, power / sum(powers)) for index, power in zip(indices, powers)]
        # The planes of the glass by outward normals: right facet (its half has x > 0), left facet, back.
        turn, place = turned(prism.get("tilt_deg", [0, 0, 0])), np.array(prism.get("position_mm", [0.0, 0.0, 0.0]))
        a, ridge = math.radians(prism["facet_angle_deg"]), np.array([0, 0, prism["ridge_distance_mm"]])
        self.normals = [turn @ v for v in ([math.sin(a), 0, -math.cos(a)], [-math.sin(a), 0, -math.cos(a)], [0, 0, 1])]
        corners = [place + turn @ ridge] * 2 + [place + turn @ (ridge + [0, 0, prism["thickness_mm"]])]
        self.offsets = [n @ p for n, p in zip(self.normals, corners)]
        self.ridge = (corners[0], turn @ [0, 1, 0])
        self.turn, self.middle = turned(self.board.get("tilt_deg", [0, 0, 0])), np.array(self.board["position_mm"])

    # ------------------------------------------------------------ from an image position to the glass

    def pupil(self, q, r):
        """Points of the aperture, even in area: of the pentagon's triangles q chooses one and a place across it, the root
        of r how far out."""
        if self.lens is None:
            return 0 * q, 0 * q
        # The thin lens equation, 1/f = 1/focus + 1/image (Born & Wolf, 4.4; Hecht, Optics, 5.2.3); the polygon's corners lie
        # on the circle of diameter f / f_number.
        radius = 1 / (1 / self.lens["focus_mm"] + 1 / self.image) / self.lens["f_number"] / 2
        n, first = self.lens["blades"], math.radians(self.lens["rotation_deg"])
        k, w = np.floor(q * n), q * n % 1
        corner = [np.stack([np.cos(first + 2 * np.pi * j / n), np.sin(first + 2 * np.pi * j / n)]) for j in (k, k + 1)]
        return radius * np.sqrt(r) * ((1 - w) * corner[0] + w * corner[1])

    def rays(self, x, y, p):
        """Origins, unit directions, and the cosine law, of image positions through points p of the pupil: all rays of a
        position meet in the plane in focus."""
        tx, ty = ((v - size / 2) * self.pitch / self.image for v, size in zip((x, y), self.size))
        far = self.lens["focus_mm"] if self.lens else 1.0
        origin = np.stack([self.eye[0] + p[0], self.eye[1] + p[1], self.eye[2] + 0 * p[0]])
        k = unit(np.stack([tx - p[0] / far, ty - p[1] / far, 1 + 0 * tx]))
        # The sensor's point lies at -image (tx, ty, 1), upside down; cos^4 is of the angle there (Born & Wolf, 4.8.3).
        cosine = 1 / np.sqrt(1 + (tx + p[0] / self.image)**2 + (ty + p[1] / self.image)**2)
        return origin, k, cosine**self.exponent

    def fields(self, k):
        """Light of power 1: of a polariser what of its axis lies across the ray; unpolarised, two fields of half of it."""
        axis = column([0.0, 1.0, 0.0] if self.polarisation == "y" else [1.0, 0.0, 0.0], k)
        e = unit(axis - dot(axis, k) * k)
        return [e + 0j] if self.polarisation != "unpolarised" else [e * 0.5**0.5 + 0j, cross(k, e) * 0.5**0.5 + 0j]

    def way(self, face, origin, k):
        """Distance along the ray to a plane of the glass."""
        n = column(self.normals[face], k)
        return (self.offsets[face] - dot(origin, n)) / dot(k, n)

    # ------------------------------------------------------------ the board

    def at_board(self, origin, k):
        """Place on the board, in squares from its upper left corner, and its light by the lamp: the inverse square law and
        Lambert's cosine, over that at the board's middle."""
        n = self.turn[:, 2]
        t = (n @ self.middle - dot(origin, column(n, k))) / dot(k, column(n, k))
        place = origin + t * k
        local = np.tensordot(self.turn.T, place - column(self.middle, k), 1)
        b = self.board
        light = np.ones_like(t)
        if self.lamp:
            def lit(place):
                to = np.reshape(self.lamp["position_mm"], (3,) + (1,) * (place.ndim - 1)) - place
                return np.abs(dot(to, column(n, place))) / dot(to, to)**1.5
            light = self.lamp["share"] * lit(place) / lit(self.middle) + 1 - self.lamp["share"]
        return local[0] / b["square_mm"] + b["columns"] / 2, local[1] / b["square_mm"] + b["rows"] / 2, light, t > 0

    def radiance(self, u, v):
        """Of a place in squares: the upper left square is black, the margin a square wide and white."""
        i, j, b = np.floor(u), np.floor(v), self.board
        squares = (i >= 0) & (i < b["columns"]) & (j >= 0) & (j < b["rows"])
        plate = (i >= -1) & (i <= b["columns"]) & (j >= -1) & (j <= b["rows"])
        colour = np.where((i + j) % 2 == 0, b["black"], b["white"])
        return np.where(squares, colour, np.where(plate, b["white"], b["background"]))

    # ------------------------------------------------------------ light that is never reflected

    def through(self, facet, index, x, y, p):
        """Place on the board, and the share of the light, of rays through a facet (beyond the ridge as if it went on)."""
        origin, k, share = self.rays(x, y, p)
        point = origin + self.way(facet, origin, k) * k
        (inside, field), _ = split(k, self.fields(k), self.normals[facet], 1, index)
        length = self.way(2, point, inside)
        point = point + length * inside
        (out, field), _ = split(inside, field, self.normals[2], index, 1)
        u, v, lit, ahead = self.at_board(point, out)
        assert ahead.all() and (length > 0).all()
        return u, v, share * power(field) * lit * np.exp(-self.per_mm * length)

    def line(self, index, x, y, p):
        """The mean light along straight lines of image positions, each from x[0], y[0] to x[1], y[1], where the map to the
        board is taken as one of second order between ridge and ends."""
        # The ray meets the ridge where n . k = 0, n across the plane of pupil point and ridge, and k / k_z is linear.
        corner, along = self.ridge
        (origin, start, _), (_, end, _) = self.rays(x[0], y[0], p), self.rays(x[1], y[1], p)
        n = cross(column(corner, origin) - origin, np.broadcast_to(column(along, origin), origin.shape))
        a, b = dot(n, start / start[2]), dot(n, end / end[2])
        cut = np.clip(a / np.where(a == b, 1, a - b), 0, 1)
        total = np.zeros_like(cut)
        for a, b in ((0 * cut, cut), (cut, 0 * cut + 1)):
            place = lambda t, some: [((1 - t) * v[0] + t * v[1])[some] for v in (x, y)] + [[c[some] for c in p]]
            origin, k, _ = self.rays(*place((a + b) / 2, slice(None)))
            # The glass is convex: its entrance is the farther of the two facets' planes.
            right = self.way(0, origin, k) > self.way(1, origin, k)
            for facet in (0, 1):
                some = np.nonzero((right == (facet == 0)) & (b > a))
                total[some] += (b - a)[some] * self.mean(*(self.through(facet, index, *place(t, some)) for t in (a, (a + b) / 2, b)))
        return total

    def mean(self, start, middle, end):
        """The mean light of places on a line that is hardly bent, given by three of them: it crosses one line of the board's
        lattice along each axis at most."""
        along = lambda t, a, m, b: a + t * (b - a) + t * (1 - t) * (4 * m - 2 * a - 2 * b)
        cuts = [np.zeros_like(start[0])]
        for a, m, b in list(zip(start, middle, end))[:2]:
            assert (np.abs(np.floor(a) - np.floor(b)) <= 1).all()
            crosses, rise = np.floor(a) != np.floor(b), np.where(np.floor(a) != np.floor(b), b - a, 1)
            t = (np.maximum(np.floor(a), np.floor(b)) - a) / rise
            # One step of Newton's from where the chord crosses to where the parabola does.
            cuts.append(np.where(crosses, np.clip(t - t * (1 - t) * (4 * m - 2 * a - 2 * b) / rise, 0, 1), 1))
        cuts = [cuts[0], np.minimum(cuts[1], cuts[2]), np.maximum(cuts[1], cuts[2]), np.ones_like(cuts[0])]
        total = 0
        for a, b in zip(cuts, cuts[1:]):
            u, v, share = (along((a + b) / 2, *ends) for ends in zip(start, middle, end))
            total = total + (b - a) * share * self.radiance(u, v)
        return total

    # ------------------------------------------------------------ light that is reflected

    def reflected(self, index, x, y, p):
        """All light of an image position that is reflected up to `bounces` times: reflections, whether it leaves through the
        back, where it goes (an origin and a direction), and its power times the cosine law."""
        origin, k, share = self.rays(x, y, p)
        facet = np.where(self.way(0, origin, k) > self.way(1, origin, k), 0, 1)
        point = origin + np.where(facet == 0, self.way(0, origin, k), self.way(1, origin, k)) * k
        sides = [split(k, self.fields(k), self.normals[f], 1, index) for f in (0, 1)]
        pick = lambda f: [np.where(facet == 0, a, b) for a, b in zip(f(sides[0]), f(sides[1]))]
        inside, field = pick(lambda s: s[0][:1])[0], pick(lambda s: s[0][1])
        yield 1, np.zeros_like(x, bool), point, pick(lambda s: s[1][:1])[0], share * power(pick(lambda s: s[1][1]))
        for count in range(self.ghosts["bounces"] + 1):
            # Out of a convex body light goes through the nearest of the planes that it meets from inside.
            ahead = [dot(inside, column(n, inside)) > 0 for n in self.normals]
            ways = [np.where(to, self.way(f, point, inside), np.inf) for f, to in enumerate(ahead)]
            face, length = np.argmin(ways, 0), np.min(ways, 0)
            point = point + length * inside
            field = [e * np.exp(-self.per_mm * length / 2) for e in field]
            sides = [split(inside, field, n, index, 1) for n in self.normals]
            choose = lambda f: [np.choose(face, parts) for parts in zip(*(f(s) for s in sides))]
            if count > 0:
                yield count, face == 2, point, choose(lambda s: s[0][:1])[0], share * power(choose(lambda s: s[0][1]))
            inside, field = choose(lambda s: s[1][:1])[0], choose(lambda s: s[1][1])

    def ghost_light(self, index, x, y, p):
        total = 0
        for _, back, origin, k, share in self.reflected(index, x, y, p):
            u, v, lit, ahead = self.at_board(origin, k)
            assert (ahead | ~back | (share == 0)).all()
            total = total + share * np.where(back, lit * self.radiance(u, v), self.ghosts["behind"])
        return total

    # ------------------------------------------------------------ pixels

    def pixel(self, i, j, points, ghost_points, shift=0.5):
        """Mean light of the part of a pixel that collects light: straight, and of ghosts."""
        def spread(points):
            k = np.arange(points)
            s, y, q, r = ((k * step + shift * (n + 1)) % 1 for n, step in enumerate(STEPS))
            return s, y, self.pupil(q, np.abs(2 * r - 1)), (k + 0.5) / points
        # All but ghosts is continuous and, with r there and back, periodic: weights that fade at both ends of such a
        # sequence make its mean converge faster (Niederreiter, Random Number Generation, 1992, 4.1).
        s, _, p, weight = spread(points)
        weight = 6 * weight * (1 - weight)
        put = lambda x, y: (i + 0.5 + (x - 0.5) * self.active, j + 0.5 + (y - 0.5) * self.active)
        straight = ghosts = 0.0
        for index, share in self.lights:
            # Slanting lines from (s, 0) on, which go on at the left border where they reach the right one: they fill the
            # pixel evenly, and no line of the board is along them.
            for start, end in ((put(s, 0 * s), put(1 + 0 * s, 1 - s)), (put(0 * s, 1 - s), put(s, 1 + 0 * s))):
                length = (end[0] - start[0]) / self.active
                straight += share * (weight * length * self.line(index, *zip(start, end), p)).mean()
            if self.ghosts:
                x, y, pupil, _ = spread(ghost_points)
                ghosts += share * self.ghost_light(index, *put(x, y), pupil).mean()
        return straight, ghosts

    def value(self, light):
        """What the sensor makes of it: electrons, full well, converter, gamma (EMVA 1288, linear model, without its noise)."""
        s = self.sensor
        electrons = min(s["white_e"] * light + s["dark_e"], s["full_well_e"])
        largest = 2**s["adc_bits"] - 1
        number = min(max(math.floor(electrons * s["gain_dn_per_e"] + s["black_level_dn"] + 0.5), 0), largest)
        return (number / largest)**(1 / s["gamma"])


# ---------------------------------------------------------------- the tables

def write(name, about, columns, rows):
    with open(os.path.join(HERE, name), "w", newline="\n") as out:
        out.write("# made by: python3 tests/oracle/effects.py (numpy %s)\n" % np.__version__)
        for line in about:
            out.write("# %s\n" % line)
        out.write(columns + "\n")
        for row in rows:
            out.write(",".join("%.*g" % x if isinstance(x, tuple) else str(x) for x in row) + "\n")


def effects_rows():
    bench = Bench("effects_scene.toml")
    pixels = [(i, j) for j in (0, 3, 6, 9, 12, 15) for i in (0, 4, 8, 12, 16, 20, 23)]
    pixels += [(i, j) for left, top in ((9, 7), (15, 13)) for j in range(top, top + 3) for i in range(left, left + 3)]
    for i, j in pixels:
        straight, ghosts = bench.pixel(i, j, 1 << 16, 1 << 15)
        yield i, j, (7, straight), (7, ghosts), (7, bench.value(straight + ghosts))


def ghost_rows():
    bench = Bench("ghosts_scene.toml")
    for x, y in ((0.0, 0.0), (7.5, 3.5), (13.0, 16.25), (16.5, 10.5), (23.25, 8.0), (32.0, 20.0)):
        at = [np.array([v]) for v in (x, y)]
        for count, back, origin, k, power in bench.reflected(bench.lights[0][0], *at, bench.pupil(*at)):
            u, v, _, _ = bench.at_board(origin, k)
            place = [""] * 2
            if back[0]:
                place = [(15, (w[0] - bench.board[n] / 2) * bench.board["square_mm"]) for w, n in ((u, "columns"), (v, "rows"))]
            yield x, y, count, (15, power[0]), *place, *((15, c[0]) for c in k)


def ghost_picture_rows():
    bench = Bench("ghosts_scene.toml")
    for j in range(bench.size[1]):
        for i in range(bench.size[0]):
            yield i, j, *((7, light) for light in bench.pixel(i, j, 1 << 11, 1 << 16))


def main():
    write("ghosts.csv", [
        "The light of single image positions of ghosts_scene.toml that is reflected: how often, its power of 1 that comes in,",
        "the place on the board in mm of what leaves through the back (of what leaves through a facet, nothing), and its unit",
        "direction. All is right to 1e-12 of itself."],
        "x_px,y_px,reflections,power,u_mm,v_mm,out_x,out_y,out_z", ghost_rows())
    write("ghosts_picture.csv", [
        "Pixels (column, row) of ghosts_scene.toml: mean radiance of the light that is never reflected, and of ghosts, of full",
        "scale 1. The first is right to 1e-6, the second to 4e-6."],
        "x,y,straight,ghosts", ghost_picture_rows())
    write("effects.csv", [
        "Some pixels (column, row) of effects_scene.toml: mean radiance of the light that is never reflected and of ghosts over",
        "the part of the pixel that collects light, of full scale 1; and what the sensor makes of their sum, of full scale 1.",
        "The first is right to 1.5e-5 (most to 4e-6), the second to 3e-6, the third to 3e-5; 0.966918 is a full well."],
        "x,y,straight,ghosts,value", effects_rows())


if __name__ == "__main__":
    sys.exit(main())
