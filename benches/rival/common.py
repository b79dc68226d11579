"""The scene that all draw, pictures as arrays, CPU time, and the figures of a row."""

import os
import resource
import subprocess
import sys

import cv2
import numpy as np

WIDTH, HEIGHT, PITCH, FOCAL = 1920, 1080, 0.0055, 35.0
INDEX, RIDGE, BASE, ANGLE = 1.48, 78.472, 87.017, 8.85428
BOARD, SQUARE, COUNT, BLACK, WHITE = 1000.0, 10.0, 41, 0.05, 0.85
# The thin lens: its f-number, the distance at which it is in focus, and the diameter of its pupil (`f_number` of
# `effect.thin_lens` is the focal length over it, by the thin lens equation from the distance and that to the sensor).
F_NUMBER, FOCUS = 4.0, 600.0
PUPIL = 1.0 / (1.0 / FOCAL + 1.0 / FOCUS) / F_NUMBER

FLAT = f"""kind = "flat"
index = {INDEX}
ridge_distance_mm = {RIDGE}
thickness_mm = {BASE - RIDGE}
facet_angle_deg = {ANGLE}
"""
# One piece of glass, as other programs trace it.
FREEFORM = FLAT.replace('"flat"', '"freeform"').replace(f"facet_angle_deg = {ANGLE}", "solid = true")
CAMERA = f"""[camera]
focal_length_mm = {FOCAL}
width_px = {WIDTH}
height_px = {HEIGHT}
pixel_pitch_um = {1e3 * PITCH}
"""
SCENE = f"""name = "rivals"
accuracy = "LEVEL"
{CAMERA}[prism]
PRISM
[board]
columns = {COUNT}
rows = {COUNT}
square_mm = {SQUARE}
position_mm = [0.0, 0.0, {BOARD}]
black = {BLACK}
white = {WHITE}
[output]
encoding = "linear"
"""


def lens(points):
    """The part of a scene that puts a thin lens in place of the pinhole."""
    return f"[effect.thin_lens]\nf_number = {F_NUMBER}\nfocus_mm = {FOCUS}\n[quadrature]\npoints = {points}\n"


def scene_file(folder, name, level, prism, more=""):
    path = os.path.join(folder, f"{name}.toml")
    with open(path, "w") as file:
        file.write(SCENE.replace("LEVEL", level).replace("PRISM", prism) + more)
    return path


def picture(path):
    """The mean of the channels of a picture in linear light, of full scale 1."""
    pixels = cv2.imread(path, cv2.IMREAD_UNCHANGED)
    full = np.iinfo(pixels.dtype).max
    pixels = pixels.reshape(*pixels.shape[:2], -1)[..., :3]
    return pixels.mean(axis=2) / full


def cpu(who):
    used = resource.getrusage(who)
    return used.ru_utime + used.ru_stime


def command(arguments, **options):
    """Runs a command; its CPU seconds."""
    before = cpu(resource.RUSAGE_CHILDREN)
    done = subprocess.run(arguments, capture_output=True, text=True, **options)
    if done.returncode != 0:
        raise RuntimeError(f"{arguments[0]} ended with {done.returncode}: {done.stderr[-400:]}")
    return cpu(resource.RUSAGE_CHILDREN) - before


def least(work, times=3):
    """The result of the run with the least CPU seconds, which come first in it."""
    return min((work() for _ in range(times)), key=lambda made: made[0])


def biprism(program, folder, level, prism, more="", times=3):
    """CPU seconds and picture of a whole command."""
    scene, out = scene_file(folder, "scene", level, prism, more), os.path.join(folder, "scene.png")
    return least(lambda: (command([program, "render", scene, "--out", out]), picture(out)), times)


def picture_table(reference):
    """Prints the head of a table of pictures held against `reference`, and gives what prints a row."""
    edges = ((reference > BLACK + 1e-3) & (reference < WHITE - 1e-3)).mean()
    print(f"{edges * 100:.2f} % of the pixels hold an edge")
    print(f"{'':44} {'CPU s':>9} {'RMSE':>9} {'shift px':>9} {'factor':>7}")

    def row(name, seconds, picture):
        factor = (reference * picture).sum() / (picture * picture).sum()
        rmse = np.sqrt(((factor * picture - reference) ** 2).mean())
        shift = rmse / np.sqrt(edges) / (WHITE - BLACK)
        print(f"{name:44} {seconds:9.3f} {rmse:9.2e} {shift:9.2e} {factor:7.4f}", flush=True)

    return row


def missing(what, package):
    print(f"{what} is not installed: {package}", file=sys.stderr)
