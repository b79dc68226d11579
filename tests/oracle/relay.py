"""Pencils of rays and their spots, by Optiland, a program that shares no line with the simulator.

    pip install optiland==0.6.3
    python3 tests/oracle/relay.py     # writes relay_rays.csv and relay_spots.csv beside this script

What is traced: a thick lens, from a point on its axis and from one beside it; a thick plate aslant; the flat prism of the
design paper; its freeform prism, of the prism.toml beside this script. Optiland chooses the rays of the lens and of the plate
(its chief ray and its hexapolar pupil), and its own spot diagram tells their sizes; through a prism, which it cannot aim at,
a fan about the middle of the half image goes. Lengths in mm; z along the axis, from the point's plane z = 0.
"""

import math
import os
import tomllib
from importlib.metadata import version

import numpy as np
from optiland.analysis import SpotDiagram
from optiland.analysis.spot_diagram.core import SpotData
from optiland.materials import IdealMaterial
from optiland.optic import Optic
from optiland.rays import RealRays

HERE = os.path.dirname(os.path.abspath(__file__))
WAVELENGTH_UM = 0.4861327
# The design paper's: index, half-image centre over focal length, ridge and base.
INDEX, SLOPE, RIDGE, BASE = 1.48, 2.64 / 35.0, 78.472, 87.017


def optic(surfaces, focus, point=(0.0, 0.0), na=0.05):
    """An object plane z = 0 with one point, the surfaces, and the image plane z = `focus`."""
    lens = Optic()
    lens.surfaces.add(index=0, z=0.0)
    # Optiland aims at a stop that is not aslant.
    stop = dict(z=20.0, is_stop=True)
    for k, surface in enumerate([stop, *surfaces]):
        lens.surfaces.add(index=k + 1, **surface)
    lens.surfaces.add(index=len(surfaces) + 2, z=focus)
    lens.set_aperture("objectNA", na)
    lens.fields.set_type("object_height")
    lens.fields.add(x=point[0], y=point[1])
    lens.wavelengths.add(value=WAVELENGTH_UM, is_primary=True)
    return lens


def traced(lens, x, y, slopes):
    """RealRays from (x, y, 0) through all surfaces."""
    d = np.column_stack([slopes, np.ones(len(slopes))])
    d /= np.linalg.norm(d, axis=1)[:, None]
    n = len(d)
    rays = RealRays(np.full(n, x), np.full(n, y), np.zeros(n), d[:, 0], d[:, 1], d[:, 2], np.ones(n), np.full(n, WAVELENGTH_UM))
    lens.surfaces.trace(rays)


def rows(name, role, lens):
    """The rays that were traced last: start, where and how they leave the last surface, path so far, place in the image plane."""
    group = lens.surfaces
    at = lambda what, surface: np.asarray(getattr(group, what))[surface, :]
    for k in range(np.asarray(group.x).shape[1]):
        start = at("L", 0)[k] / at("N", 0)[k], at("M", 0)[k] / at("N", 0)[k]
        back = [at(what, -2)[k] for what in ("x", "y", "z", "L", "M", "N", "opd")]
        yield [name, role, at("x", 0)[k], at("y", 0)[k], *start, *back, at("x", -1)[k], at("y", -1)[k]]


def spot(lens, data, reference):
    """Root mean square and largest distance from the reference, by Optiland."""
    diagram = SpotDiagram(lens, num_rings=3, reference=reference)
    diagram.data = [[data]]
    return float(diagram.rms_spot_radius()[0][0]), float(diagram.geometric_spot_radius()[0][0])


def aimed_case(name, surfaces, focus, point):
    """Optiland's own chief ray and pupil of a point, and its own spots."""
    lens = optic(surfaces, focus, point)
    diagrams = [SpotDiagram(lens, num_rings=RINGS, reference=reference) for reference in ("centroid", "chief_ray")]
    rms = [float(d.rms_spot_radius()[0][0]) for d in diagrams]
    radius = float(diagrams[1].geometric_spot_radius()[0][0])
    field = diagrams[0].fields[0].coord
    lens.trace_generic(*field, 0.0, 0.0, WAVELENGTH_UM)
    table = list(rows(name, "chief", lens))
    lens.trace(*field, WAVELENGTH_UM, RINGS, "hexapolar")
    table += list(rows(name, "pupil", lens))
    return table, [name, focus, *rms, radius]


def fan_case(name, surfaces, focus):
    """A fan about the middle of the right half image."""
    lens = optic(surfaces, focus)
    traced(lens, 0.0, 0.0, [(SLOPE, 0.0)])
    table = list(rows(name, "chief", lens))
    chief = np.asarray(lens.surfaces.x)[-1, 0], np.asarray(lens.surfaces.y)[-1, 0]
    share = np.linspace(-1, 1, 7)
    slopes = [(SLOPE + u * 2.64 / 35.0, v * 2.97 / 35.0) for u in share for v in share]
    traced(lens, 0.0, 0.0, slopes)
    table += list(rows(name, "pupil", lens))
    x, y = (np.asarray(getattr(lens.surfaces, what))[-1, :] for what in "xy")
    # About the centroid Optiland finds the reference itself; the chief ray's place is taken away beforehand.
    data = SpotData(x=x, y=y, intensity=np.ones(len(x)))
    rms, _ = spot(lens, data, "centroid")
    far = np.hypot(x - chief[0], y - chief[1])
    return table, [name, focus, rms, math.sqrt(np.mean(far**2)), far.max()]


def polynomial(part, surface):
    """A polynomial of prism.toml as Optiland's, about its own centre, in powers of mm."""
    (x0, y0), (sx, sy) = part["centre_mm"], part["scale_mm"]
    degree = max(max(m, n) for m, n, _ in part["terms"])
    c = np.zeros((degree + 1, degree + 1))
    for m, n, value in part["terms"]:
        c[m, n] = value / sx**m / sy**n
    z = c[0, 0]
    c[0, 0] = 0.0
    return dict(surface_type="polynomial", coefficients=c, radius=math.inf, tol=1e-14, x=x0, y=y0, z=z, **surface)


RINGS = 4


def main():
    glass = lambda n: IdealMaterial(n=n)
    lens = [dict(z=80.0, radius=60.0, material=glass(1.5168)), dict(z=89.0, radius=-45.0, material="air")]
    turn = dict(rx=math.radians(-15.0), ry=math.radians(25.0))
    # The normal of the plate, z turned as the surfaces are: about x, then about y.
    plate = [dict(z=60.0, material=glass(1.62), **turn), dict(z=76.0, material="air", **turn)]
    alpha = math.atan(math.sin(math.atan(SLOPE)) / (INDEX - math.cos(math.atan(SLOPE))))
    flat = [dict(z=RIDGE, ry=-alpha, material=glass(INDEX)), dict(z=BASE, material="air")]
    with open(os.path.join(HERE, "prism.toml"), "rb") as file:
        prism = tomllib.load(file)["prism"]
    freeform = [polynomial(prism["front"], dict(material=glass(INDEX))), polynomial(prism["back"], dict(material="air"))]
    cases = [
        aimed_case("lens", lens, 200.0, (0.0, 0.0)),
        aimed_case("lens_beside", lens, 200.0, (0.8, -1.2)),
        aimed_case("plate", plate, 0.0, (0.0, 0.0)),
        fan_case("flat", flat, 0.0),
        fan_case("freeform", freeform, 0.0),
    ]
    made = f"# made by: python3 tests/oracle/relay.py (optiland {version('optiland')}, numpy {np.__version__})\n"
    text = lambda row: ",".join(v if isinstance(v, str) else repr(float(v)) for v in row) + "\n"
    with open(os.path.join(HERE, "relay_rays.csv"), "w", newline="\n") as out:
        out.write(made)
        out.write("# Rays from (from_x, from_y, 0) in the direction (slope_x, slope_y, 1): where they leave the last surface, their\n")
        out.write("# unit direction there, the optical path so far, and where they meet the plane of the spot. Lengths in mm.\n")
        out.write("case,role,from_x,from_y,slope_x,slope_y,x,y,z,dx,dy,dz,path,plane_x,plane_y\n")
        out.writelines(text(row) for table, _ in cases for row in table)
    with open(os.path.join(HERE, "relay_spots.csv"), "w", newline="\n") as out:
        out.write(made)
        out.write("# The spots of the rays of relay_rays.csv that are of the pupil in the plane z = plane: root mean square about the\n")
        out.write("# centroid and about the chief ray, largest distance from that, in mm.\n")
        out.write("case,plane,rms,rms_about_chief,radius\n")
        out.writelines(text(row) for _, row in cases)


if __name__ == "__main__":
    main()
