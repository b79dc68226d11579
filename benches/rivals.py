#!/usr/bin/env python3
"""The same work by other programs, with its cost and its error: python3 benches/rivals.py [BIPRISM] [--only flat,lens,...]

Pictures of 1920 x 1080 px of a checkerboard through the prism of the design paper, refraction only:

  flat      two facets of an angle of 8.85428 deg
  freeform  polynomials of degree 5; to Mitsuba as 10^6 triangles with the normals of the polynomials
  lens      the flat prism before a thin lens, f/4, in focus at 600 mm
  mesh      the freeform prism as triangles with smooth normals, held against its polynomials: as the bodies that `biprism export`
            writes, of about 10^4 and 10^6, whose normals follow from the triangles; to the others 10^4 with those of the polynomials

and then

  corners   390 corners of a board by a pinhole, 8 bits, sharp and with noise
  rays      10^6 rays from the pinhole to the board

BIPRISM is the command, target/release/biprism if not given. NumPy and OpenCV are needed (pip install numpy
opencv-python-headless); a rival that is not installed is named and left out: povray (a program of this name), mitsuba, optiland,
batoid (pip install). Mitsuba's fast variant needs LLVM, of DRJIT_LIBLLVM_PATH where it is not found.

CPU seconds, user and system, of all threads: of whole commands for biprism and POV-Ray, with the files they read and write, of the
work alone for the others (Mitsuba compiles its kernels on a first picture, not counted). The least of three runs for biprism.
RMSE: against a picture by biprism that is named, of full scale 1, after a common factor of each rival is taken out, which is
shown: light that Mitsuba's glass reflects is lost. Shift: RMSE over the pixels that hold an edge, as a share of the contrast;
an edge that moves by a share of a pixel changes its pixels by that share, so this is about how far edges are off, in px.

Blur: the pupil has the diameter f/N, with f by the thin lens equation from the focus and the distance to the sensor. Mitsuba's
`thinlens` takes its radius. POV-Ray's `aperture` is twice the diameter: of 0.5 to 2.2 times the diameter, 1.95 to 2 gives the picture
of the others. The focus of all is a plane.
"""

import argparse
import importlib.util
import os
import shutil
import sys
import tempfile

from rival.common import FLAT, FREEFORM, biprism, lens, missing, picture_table, scene_file

TRIANGLES, FEW = 1_000_000, 10_000


def mitsuba_rows(row, folder, variants, **scene):
    """Rows of Mitsuba by the first of `variants` (name, samples) that runs here."""
    from rival import mitsuba_scene

    if importlib.util.find_spec("mitsuba") is None:
        return missing("Mitsuba", "pip install mitsuba")
    for variant, counts in variants:
        try:
            for samples in counts:
                row(f"Mitsuba {variant}, {samples} spp", *mitsuba_scene.render(folder, variant, samples, **scene))
            return None
        except RuntimeError as problem:
            print(f"Mitsuba {variant} does not run here, maybe for want of LLVM (DRJIT_LIBLLVM_PATH): {problem}", file=sys.stderr)
    return None


def povray_rows(row, folder, body, options, blur=0):
    from rival import povray

    if shutil.which("povray") is None:
        return missing("POV-Ray", "the program povray")
    for name, switches in options:
        row(f"POV-Ray, {name}", *povray.render(folder, body, switches, blur))
    return None


ONE = ("one sample", ["-A"])
GRIDS = [("+AM1 +A0.01 +R4", ["+AM1", "+A0.01", "+R4"]), ("+AM1 +A0.01 +R9", ["+AM1", "+A0.01", "+R9"])]
FAST, SLOW = "llvm_ad_mono", "scalar_rgb"


def flat(program, folder):
    from rival import numpy_flat, povray

    row = picture_table(biprism(program, folder, "exact", FLAT, times=1)[1])
    for level in ("draft", "standard", "exact"):
        row(f"biprism, {level}", *biprism(program, folder, level, FLAT))
    for n in (1, 4, 8):
        row(f"NumPy, {n} x {n}", *numpy_flat.render(n))
    povray_rows(row, folder, povray.flat(), [ONE, *GRIDS])
    mitsuba_rows(row, folder, [(FAST, (1, 16, 64)), (SLOW, (1, 16))])


def freeform(program, folder):
    from rival import povray, surfaces

    row = picture_table(biprism(program, folder, "exact", FREEFORM, times=1)[1])
    for level in ("draft", "standard", "exact"):
        row(f"biprism, {level}", *biprism(program, folder, level, FREEFORM))
    sheets = surfaces.polynomials(program, scene_file(folder, "freeform", "exact", FREEFORM), folder)
    povray_rows(row, folder, povray.freeform(sheets), [ONE, GRIDS[0]])
    body = surfaces.body(sheets, TRIANGLES)
    mitsuba_rows(row, folder, [(FAST, (1, 16, 64)), (SLOW, (1, 16))], sheets=body, smooth=True)


def thin_lens(program, folder):
    from rival import povray

    row = picture_table(biprism(program, folder, "standard", FLAT, lens(2048), times=1)[1])
    for points in (32, 128, 1024):
        row(f"biprism, standard, {points} points", *biprism(program, folder, "standard", FLAT, lens(points)))
    povray_rows(row, folder, povray.flat(), [("37 blur samples", ["-A"])], blur=37)
    mitsuba_rows(row, folder, [(FAST, (16, 64, 256)), (SLOW, (16,))], lens=True)


def mesh(program, folder):
    from rival import povray, surfaces

    row = picture_table(biprism(program, folder, "exact", FREEFORM, times=1)[1])
    scene = scene_file(folder, "freeform", "exact", FREEFORM)
    prism = 'kind = "mesh"\nindex = 1.48\nbody = "body.ply"\n'
    for chord_mm in ("4.6e-4", "4.6e-6"):
        triangles = surfaces.solid(program, scene, os.path.join(folder, "body.ply"), chord_mm)
        row(f"biprism, standard, {triangles} triangles", *biprism(program, folder, "standard", prism, times=2))
    body = surfaces.body(surfaces.polynomials(program, scene, folder), FEW)
    povray_rows(row, folder, povray.triangles(body), [ONE, GRIDS[0]])
    mitsuba_rows(row, folder, [(FAST, (1, 16, 64)), (SLOW, (1,))], sheets=body, smooth=True)


def corners(program, folder):
    from rival import corners as detectors

    detectors.table(program, folder)


def rays(program, folder):
    from rival import rays as tracers

    tracers.table(program, folder)


TABLES = {"flat": flat, "freeform": freeform, "lens": thin_lens, "mesh": mesh, "corners": corners, "rays": rays}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    built = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../target/release/biprism")
    parser.add_argument("biprism", nargs="?", default=built)
    parser.add_argument("--only", default=",".join(TABLES), help="tables, with commas between")
    asked = parser.parse_args()
    if shutil.which(asked.biprism) is None:
        parser.error(f"{asked.biprism} is not there: cargo build --release, or name the command")
    unknown = set(asked.only.split(",")) - set(TABLES)
    if unknown:
        parser.error(f"there is no table {', '.join(sorted(unknown))}: there are {', '.join(TABLES)}")
    program = os.path.abspath(shutil.which(asked.biprism))
    for name in asked.only.split(","):
        print(f"\n{name}")
        with tempfile.TemporaryDirectory() as folder:
            TABLES[name](program, folder)


if __name__ == "__main__":
    for needed, package in (("numpy", "numpy"), ("cv2", "opencv-python-headless")):
        if importlib.util.find_spec(needed) is None:
            sys.exit(f"{package} is not installed: pip install {package}")
    main()
