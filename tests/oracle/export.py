"""What `biprism export --format optiland` writes, read and traced by Optiland, a program that shares no line with the simulator.

    pip install optiland==0.6.3
    python3 tests/oracle/export.py target/release/biprism     # writes export_optiland.csv beside this script

Rays of some pixels of both halves go from the pinhole through the lens file of their half to the plane of the board. Where they
start and what is the board's x and y follows from the scene's numbers alone, here, by rotation matrices of NumPy. Lengths in mm.
"""

import os
import subprocess
import sys
import tempfile
import tomllib
from importlib.metadata import version

import numpy as np
from optiland.fileio import load_optiland_file
from optiland.rays import RealRays

HERE = os.path.dirname(os.path.abspath(__file__))
CASES = ["prism_freeform", "board_tilted", "prism_water", "prism_tilted", "prism_epipolar"]
# Shares of a half's width and height, away from the ridge, which the tilted prism has elsewhere.
PLACES = [(x, y) for x in (0.12, 0.5, 0.88) for y in (0.05, 0.4, 0.95)]


def pose(table):
    """Rotation about the fixed x, then y, then z axis, and translation, of a part of a scene."""
    (a, b, c) = np.radians(table.get("tilt_deg", [0.0, 0.0, 0.0]))
    x = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
    y = np.array([[np.cos(b), 0, np.sin(b)], [0, 1, 0], [-np.sin(b), 0, np.cos(b)]])
    z = np.array([[np.cos(c), -np.sin(c), 0], [np.sin(c), np.cos(c), 0], [0, 0, 1]])
    return z @ y @ x, np.array(table.get("position_mm", [0.0, 0.0, 0.0]))


def traced(lens, start, directions):
    """Where rays meet the last surface of a lens file."""
    n = len(directions)
    column = lambda value: np.full(n, float(value))
    rays = RealRays(*(column(v) for v in start), *directions.T, np.ones(n), column(0.5876))
    lens.surfaces.trace(rays)
    return np.column_stack([np.asarray(getattr(lens.surfaces, what))[-1, :] for what in "xyz"])


def case(program, name, folder):
    """The rows of a scene."""
    path = os.path.join(HERE, "../../scenes/cases", name + ".toml")
    with open(path, "rb") as file:
        scene = tomllib.load(file)
    camera, prism, board = scene["camera"], pose(scene["prism"]), pose(scene["board"])
    width, height = camera["width_px"], camera["height_px"]
    pitch = camera["pixel_pitch_um"] / 1000 / camera["focal_length_mm"]
    subprocess.run([program, "export", path, "--format", "optiland", "--out", folder], check=True, capture_output=True)
    for side, first in (("left", 0), ("right", width / 2)):
        px = np.array([(first + u * width / 2, v * height) for u, v in PLACES])
        slopes = (px - [width / 2, height / 2]) * pitch
        d = np.column_stack([slopes, np.ones(len(px))])
        d /= np.linalg.norm(d, axis=1)[:, None]
        # The camera is at the origin of the world; the file is in the prism's frame.
        (turn, move), (turned, moved) = prism, board
        lens = load_optiland_file(os.path.join(folder, side + ".json"))
        met = traced(lens, -move @ turn, d @ turn)
        seen = (met @ turn.T + move - moved) @ turned
        assert np.abs(seen[:, 2]).max() < 1e-9, seen
        yield from ([name, side, *px[k], *seen[k, :2]] for k in range(len(px)))


def main():
    with tempfile.TemporaryDirectory() as folder:
        rows = [row for name in CASES for row in case(sys.argv[1], name, folder)]
    text = lambda row: ",".join(v if isinstance(v, str) else repr(float(v)) for v in row) + "\n"
    with open(os.path.join(HERE, "export_optiland.csv"), "w", newline="\n") as out:
        out.write(f"# made by: python3 tests/oracle/export.py (optiland {version('optiland')}, numpy {np.__version__})\n")
        out.write("# Where the rays of pixel positions of scenes/cases meet the board, in mm on it, through the exported file of their half.\n")
        out.write("case,side,px_x,px_y,board_x,board_y\n")
        out.writelines(text(row) for row in rows)


if __name__ == "__main__":
    main()
