"""Rays through a half of the prism to the board: arrays of positions, each in f64."""

import importlib.util
import os
import time

import numpy as np

from .common import ANGLE, BASE, BOARD, FLAT, FOCAL, FREEFORM, HEIGHT, INDEX, PITCH, RIDGE, WIDTH
from .common import command, least, missing, scene_file

RAYS = 1_000_000


def pixels():
    """Positions in the right half, drawn at random."""
    return np.random.default_rng(1).uniform([WIDTH / 2 + 20, 0], [WIDTH, HEIGHT], (RAYS, 2))


def directions(px):
    d = np.column_stack([(px - [WIDTH / 2, HEIGHT / 2]) * (PITCH / FOCAL), np.ones(len(px))])
    return d / np.linalg.norm(d, axis=1)[:, None]


def by_biprism(program, folder, scene, px):
    """CPU seconds of the whole command, and where the rays meet the board."""
    points, out = os.path.join(folder, "points.npy"), os.path.join(folder, "rays.npy")
    np.save(points, px)
    seconds = command([program, "trace", scene, "--in", points, "--out", out])
    return seconds, np.load(out)["board_mm"]


def by_optiland(program, folder, scene, px):
    """CPU seconds of the trace alone through the file that `biprism export` writes."""
    from optiland.fileio import load_optiland_file
    from optiland.rays import RealRays

    command([program, "export", scene, "--format", "optiland", "--out", folder, "--quiet"])
    lens = load_optiland_file(os.path.join(folder, "right.json"))
    zero = np.zeros(len(px))
    rays = RealRays(zero, zero, zero, *directions(px).T, np.ones(len(px)), np.full(len(px), 0.5876))
    start = time.process_time()
    lens.surfaces.trace(rays)
    seconds = time.process_time() - start
    return seconds, np.column_stack([np.asarray(getattr(lens.surfaces, what))[-1, :] for what in "xy"])


def by_batoid(px):
    """CPU seconds of the trace alone through the flat prism's right half; batoid traces in C++."""
    import batoid

    glass, air = batoid.ConstMedium(INDEX), batoid.ConstMedium(1.0)
    d = directions(px)
    start = [np.zeros(len(px))] * 3
    rays = batoid.RayVector(*start, *d.T.copy())
    angle = np.radians(ANGLE)
    turn = np.array([[np.cos(angle), 0.0, -np.sin(angle)], [0.0, 1.0, 0.0], [np.sin(angle), 0.0, np.cos(angle)]])
    places = [
        batoid.CoordSys(np.array([0.0, 0.0, RIDGE]), turn),
        batoid.CoordSys(np.array([0.0, 0.0, BASE]), np.eye(3)),
        batoid.CoordSys(np.array([0.0, 0.0, BOARD]), np.eye(3)),
    ]
    began = time.process_time()
    plane = batoid.Plane()
    plane.refract(rays, air, glass, coordSys=places[0])
    plane.refract(rays, glass, air, coordSys=places[1])
    plane.intersect(rays, coordSys=places[2])
    seconds = time.process_time() - began
    return seconds, np.column_stack([rays.x, rays.y])


def table(program, folder):
    """Prints the time of a ray, and how far from biprism's the rays end."""
    print(f"{RAYS} rays to the board {'':19} {'CPU s':>9} {'ns a ray':>9} {'RMS mm':>9} {'worst mm':>9}")
    px = pixels()
    # Each half by itself, as the exported lens files are.
    for kind, prism in (("flat", FLAT), ("freeform", FREEFORM.replace("true", "false"))):
        scene = scene_file(folder, kind, "standard", prism)
        own = least(lambda: by_biprism(program, folder, scene, px))
        row(f"biprism trace, {kind}, whole command", *own, own[1])
        if importlib.util.find_spec("optiland"):
            row(f"Optiland, {kind}", *by_optiland(program, folder, scene, px), own[1])
        if kind == "flat" and importlib.util.find_spec("batoid"):
            row("batoid, flat", *least(lambda: by_batoid(px)), own[1])
    for module, name in (("optiland", "Optiland"), ("batoid", "batoid")):
        if importlib.util.find_spec(module) is None:
            missing(name, f"pip install {module}")


def row(name, seconds, board, reference):
    off = np.linalg.norm(board - reference, axis=1)
    figures = f"{1e9 * seconds / RAYS:9.0f} {np.sqrt((off**2).mean()):9.1e} {off.max():9.1e}"
    print(f"{name:44} {seconds:9.3f} {figures}", flush=True)
