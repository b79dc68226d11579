"""The scenes as text of POV-Ray: planes, polynomials or triangles, and a camera with an aperture."""

import math
import os

import numpy as np

from .common import ANGLE, BASE, BLACK, BOARD, FOCAL, FOCUS, HEIGHT, INDEX, PITCH, PUPIL, RIDGE, SQUARE, WHITE, WIDTH
from .common import command, picture

CAMERA = "camera {{ perspective location <0,0,0> direction <0,0,1> right x*{wide} up y*{tall} {blur} }}"
STAGE = """#version 3.7;
global_settings {{ assumed_gamma 1.0 max_trace_level 8 }}
{camera}
plane {{ <0,0,-1>, -{board}
  pigment {{ checker color rgb {white} color rgb {black} scale {square} translate {half} }}
  finish {{ ambient 0 diffuse 0 emission 1 }} }}
{body}
"""
GLASS = f"pigment {{ rgbt <1,1,1,1> }} finish {{ ambient 0 diffuse 0 }} interior {{ ior {INDEX} }}"


def flat():
    """The prism as three half-spaces."""
    sin, cos = math.sin(math.radians(ANGLE)), math.cos(math.radians(ANGLE))
    facets = "".join(f"plane {{ <{side * sin},0,{-cos}>, {-RIDGE * cos} }} " for side in (1, -1))
    return f"intersection {{ {facets} plane {{ <0,0,1>, {BASE} }} {GLASS} }}"


def freeform(surfaces):
    """Both halves, each between its two polynomials, which POV-Ray solves in f64."""
    halves = []
    for side in (1, -1):
        sheets = [polynomial(surface, side, sign) for surface, sign in zip(surfaces, (1.0, -1.0))]
        halves.append(f"intersection {{ {' '.join(sheets)} plane {{ <{-side},0,0>, 0 }} }}")
    return f"merge {{ {' '.join(halves)} {GLASS} }}"


def polynomial(surface, side, sign):
    """The half-space where sign (P(x, y) - z) is below 0, of the right half (side 1) or its mirror image (-1)."""
    (x0, y0, z0), c = surface
    terms = np.zeros(len(c))
    rows = []
    for j in range(c.shape[1]):
        # The polynomial of x - x0 as one of x.
        in_x = np.polynomial.Polynomial(c[:, j])(np.polynomial.Polynomial([-x0, side])).coef
        terms[:] = 0.0
        terms[: len(in_x)] = in_x
        rows.append(terms.copy())
    assert y0 == 0.0
    rows[0][0] += z0
    listed = [f"xyz({i},{j},0):{float(sign * row[i])!r}" for j, row in enumerate(rows) for i in range(len(row)) if row[i] != 0.0]
    return f"polynomial {{ {len(c) - 1}, {', '.join(listed)}, xyz(0,0,1):{-sign} sturm }}"


def triangles(sheets):
    """A body of sheets, each (vertices, normals, triangles), as one mesh: light goes in and out of one object."""
    first = np.cumsum([0] + [len(vertices) for vertices, _, _ in sheets])
    lists = [
        ("vertex_vectors", np.concatenate([vertices for vertices, _, _ in sheets]), "%.17g"),
        ("normal_vectors", np.concatenate([normals for _, normals, _ in sheets]), "%.17g"),
        ("face_indices", np.concatenate([faces + start for (_, _, faces), start in zip(sheets, first)]), "%d"),
    ]
    text = "".join(
        f"{name} {{ {len(rows)},\n" + ",\n".join(("<" + ",".join([form] * 3) + ">") % tuple(row) for row in rows) + " }\n"
        for name, rows, form in lists
    )
    return f"mesh2 {{ {text} {GLASS} }}\n"


def render(folder, body, options, blur_samples=0):
    """CPU seconds and picture of a whole command."""
    blur = f"aperture {2 * PUPIL} blur_samples {blur_samples} focal_point <0,0,{FOCUS}> variance 0" if blur_samples else ""
    camera = CAMERA.format(wide=WIDTH * PITCH / FOCAL, tall=HEIGHT * PITCH / FOCAL, blur=blur)
    text = STAGE.format(
        camera=camera, board=BOARD, white=WHITE, black=BLACK, square=SQUARE, half=SQUARE / 2, body=body
    )
    scene, out = os.path.join(folder, "rivals.pov"), os.path.join(folder, "rivals.png")
    with open(scene, "w") as file:
        file.write(text)
    form = [f"+W{WIDTH}", f"+H{HEIGHT}", "+FN16", "File_Gamma=1.0", "-D", "-J", f"+I{scene}", f"+O{out}"]
    return command(["povray", *form, *options], cwd=folder), picture(out)
