"""The scenes as Mitsuba takes them. Each picture is made in a process of its own, for a wrong LLVM ends it."""

import json
import os
import sys
import time

import numpy as np

from .common import ANGLE, BASE, BLACK, BOARD, COUNT, FOCAL, FOCUS, INDEX, PITCH, PUPIL, RIDGE, SQUARE, WHITE
from .common import HEIGHT, WIDTH, command
from .surfaces import write_ply

# Light that is reflected is left out, so that samples are not spent on it; what passes is dimmed, by a factor.
GLASS = {"type": "dielectric", "int_ior": INDEX, "ext_ior": 1.0, "specular_reflectance": {"type": "rgb", "value": [0.0] * 3}}


def render(folder, variant, samples, sheets=None, smooth=False, lens=False):
    """CPU seconds of the render alone, its kernels compiled before, and the picture.

    `sheets` (vertices, normals, triangles) in place of the flat prism, with the normals of their vertices where `smooth`.
    Raises RuntimeError where the variant does not run.
    """
    files = []
    for k, (vertices, normals, triangles) in enumerate(sheets or [flat_body()]):
        files.append(os.path.join(folder, f"sheet{k}.ply"))
        write_ply(files[-1], vertices, triangles, normals if smooth else None)
    out = os.path.join(folder, "mitsuba.npz")
    asked = {"variant": variant, "samples": samples, "files": files, "smooth": smooth, "lens": lens, "out": out}
    here = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
    command([sys.executable, "-m", "rival.mitsuba_scene", json.dumps(asked)], cwd=here)
    with np.load(out) as made:
        return float(made["seconds"]), made["picture"].astype(float)


def flat_body():
    """The flat prism as a closed body of triangles."""
    wide, tall = 40.0, 30.0
    back = RIDGE + wide * np.tan(np.radians(ANGLE))
    outline = ((0, RIDGE), (wide, back), (wide, BASE), (-wide, BASE), (-wide, back))
    vertices = np.array([(x, y, z) for y in (-tall, tall) for x, z in outline])
    quads = [(0, 1, 6, 5), (4, 0, 5, 9), (2, 3, 8, 7), (1, 2, 7, 6), (3, 4, 9, 8)]
    faces = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    faces += [(0, 4, 3), (0, 3, 2), (0, 2, 1), (5, 8, 9), (5, 7, 8), (5, 6, 7)]
    middle = np.array([0.0, 0.0, 0.5 * (RIDGE + BASE)])

    def outward(a, b, c):
        normal = np.cross(vertices[b] - vertices[a], vertices[c] - vertices[a])
        return (a, b, c) if normal @ (vertices[a] - middle) > 0 else (a, c, b)

    return vertices, None, np.array([outward(*face) for face in faces])


def sensor(place, lens):
    """The camera, with the aperture and the focus of the thin lens where it has one."""
    aperture = {"type": "thinlens", "aperture_radius": 0.5 * PUPIL, "focus_distance": FOCUS} if lens else {"type": "perspective"}
    return aperture | {
        "fov": float(np.degrees(2 * np.arctan(0.5 * WIDTH * PITCH / FOCAL))),
        "fov_axis": "x",
        "near_clip": 1.0,
        "to_world": place().look_at(origin=[0, 0, 0], target=[0, 0, 1], up=[0, 1, 0]),
        "film": {"type": "hdrfilm", "width": WIDTH, "height": HEIGHT, "rfilter": {"type": "box"},
                 "pixel_format": "luminance", "component_format": "float32"},
        "sampler": {"type": "stratified", "sample_count": 16},
    }


def main(asked):
    import mitsuba as mi

    mi.set_variant(asked["variant"])
    place = mi.ScalarTransform4f
    checker = {
        "type": "checkerboard",
        "color0": {"type": "rgb", "value": [BLACK] * 3},
        "color1": {"type": "rgb", "value": [WHITE] * 3},
        "to_uv": place().scale([COUNT / 2, COUNT / 2, 1]),
    }
    half = 0.5 * COUNT * SQUARE
    board = {
        "type": "rectangle",
        "to_world": place().translate([0, 0, BOARD]).rotate([0, 1, 0], 180).scale([half, half, 1]),
        "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.0] * 3}},
        "emitter": {"type": "area", "radiance": checker},
    }
    sheets = {
        f"sheet{k}": {"type": "ply", "filename": path, "face_normals": not asked["smooth"], "bsdf": GLASS}
        for k, path in enumerate(asked["files"])
    }
    path = {"type": "path", "max_depth": 6, "rr_depth": 100}
    scene = mi.load_dict({"type": "scene", "integrator": path, "sensor": sensor(place, asked["lens"]), "board": board} | sheets)
    np.array(mi.render(scene, spp=1))
    start = time.process_time()
    picture = np.array(mi.render(scene, spp=asked["samples"]))[..., 0]
    np.savez(asked["out"], seconds=time.process_time() - start, picture=picture)


if __name__ == "__main__":
    main(json.loads(sys.argv[1]))
