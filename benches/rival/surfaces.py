"""The freeform prism as other programs take it: polynomials, and triangles with their normals."""

import json
import os

import numpy as np

from .common import command

# The right half's part that the camera looks through, in mm, with a margin.
WIDE, TALL = 16.0, 10.0


def polynomials(program, scene, folder):
    """Front and back of the right half: for each the place of its frame and coefficients [i][j] of x^i y^j there."""
    command([program, "export", scene, "--format", "optiland", "--out", folder, "--quiet"])
    with open(os.path.join(folder, "right.json")) as file:
        surfaces = json.load(file)["surface_group"]["surfaces"]
    named = {surface["comment"]: surface["geometry"] for surface in surfaces}
    return [([named[k]["cs"][axis] for axis in "xyz"], np.array(named[k]["coefficients"])) for k in ("front", "back")]


def sheet(surface, columns, rows):
    """Vertices, normals and triangles of a sheet of the right half over a grid of `columns` x `rows` cells."""
    (x0, y0, z0), c = surface
    x, y = np.meshgrid(np.linspace(0.0, WIDE, columns + 1), np.linspace(-TALL, TALL, rows + 1))
    poly = np.polynomial.polynomial
    z = z0 + poly.polyval2d(x - x0, y - y0, c)
    slope = [poly.polyval2d(x - x0, y - y0, poly.polyder(c, axis=axis)) for axis in (0, 1)]
    normals = np.stack([-slope[0], -slope[1], np.ones_like(x)], axis=-1).reshape(-1, 3)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    corner = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).reshape(-1)
    a, b, c, d = corner, corner + 1, corner + columns + 2, corner + columns + 1
    triangles = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return np.stack([x, y, z], axis=-1).reshape(-1, 3), normals, triangles


def body(surfaces, triangles):
    """The four sheets of the prism, right front and back, left front and back, with normals out of the glass."""
    (front, normals, faces), back = (sheet(surface, *grid(triangles)) for surface in surfaces)
    right = [(front, -normals, faces[:, ::-1]), back]
    return right + [mirrored(*one) for one in right]


def mirrored(vertices, normals, triangles):
    """The left half's sheet, its triangles turned so that they keep their sense."""
    other = np.array([-1.0, 1.0, 1.0])
    return vertices * other, normals * other, triangles[:, ::-1]


def grid(triangles):
    """Columns and rows of the cells of one sheet, of four, that has about this many triangles in all."""
    rows = max(2, round((triangles / 8 / (WIDE / (2 * TALL))) ** 0.5))
    return max(2, round(triangles / 8 / rows)), rows


def solid(program, scene, path, chord_mm):
    """Writes the closed body, whose chords stray by so much at most; how many triangles it has."""
    command([program, "export", scene, "--format", "ply", "--tolerance-mm", chord_mm, "--out", path, "--quiet"])
    with open(path, "rb") as file:
        head = file.read(1000).decode(errors="replace")
    return int(head.split("element face ")[1].split()[0])


def write_ply(path, vertices, triangles, normals=None):
    """Binary PLY of f64, with the normals of its vertices where they are given."""
    faces = np.empty(len(triangles), dtype=[("n", "u1"), ("v", "<i4", 3)])
    faces["n"], faces["v"] = 3, triangles
    names = ["x", "y", "z"] + ([] if normals is None else ["nx", "ny", "nz"])
    columns = vertices if normals is None else np.hstack([vertices, normals])
    properties = "".join(f"property double {name}\n" for name in names)
    head = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {len(vertices)}\n{properties}element face {len(triangles)}\n"
        "property list uchar int vertex_indices\nend_header\n"
    )
    with open(path, "wb") as file:
        file.write(head.encode() + columns.astype("<f8").tobytes() + faces.tobytes())
