#!/usr/bin/env python3
"""Calibrates the stereo pair of a prism with OpenCV, from boards of which each half shows another part.

    pip install opencv-python-headless==5.0.0.*
    cargo build --release
    python3 tools/stereo_corners.py [--biprism target/release/biprism]

Twenty poses of a board that reaches beyond the view of one half or of both are rendered through the design paper's freeform prism,
their corners numbered by `biprism corners PICTURE --scene SCENE`, those that both halves show given to `cv2.stereoCalibrate`, and
its baseline compared with the distance of the two designed virtual cameras. Then the same with the lattices' own numbers, which count
from each half's own first corner. Exit code 1 where the first baseline is off by more than 0.1 mm.
"""

import argparse
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import cv2
import numpy as np

SIZE = (960, 540)
SQUARE_MM = 10.0
POSES = 20
MOST_OFF_MM = 0.1
SCENE = """name = "pose"
[camera]
focal_length_mm = 35.0
width_px = {size[0]}
height_px = {size[1]}
pixel_pitch_um = 11.0
[prism]
kind = "freeform"
index = 1.48
ridge_distance_mm = 78.472
thickness_mm = 8.545
[board]
columns = 17
rows = 14
square_mm = {square}
position_mm = {position}
tilt_deg = {tilt}
"""


def run(biprism, *arguments):
    done = subprocess.run([biprism, *map(str, arguments)], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"biprism {' '.join(map(str, arguments))}\n{done.stderr}")
    return done.stdout


def halves(text):
    """For each half the corners by index, in px from the half's own first column, as OpenCV counts them."""
    found = {}
    for half in json.loads(text)["halves"]:
        first = np.array([SIZE[0] // 2 if half["half"] == "right" else 0, 0]) + 0.5
        found[half["half"]] = {tuple(c["index"]): np.array(c["position_px"]) - first for c in half["corners"]}
    return found


def baseline_mm(views):
    """RMS in px and baseline in mm of the corners that both halves name alike."""
    board, left, right = [], [], []
    for found in views:
        both = sorted(set(found["left"]) & set(found["right"]))
        board.append(np.array([(i * SQUARE_MM, j * SQUARE_MM, 0) for i, j in both], np.float32))
        left.append(np.array([found["left"][index] for index in both], np.float32))
        right.append(np.array([found["right"][index] for index in both], np.float32))
    size = (SIZE[0] // 2, SIZE[1])
    # The designed halves are pinholes: no tangential distortion, and the radial one of two terms for what the design leaves.
    flags = cv2.CALIB_ZERO_TANGENT_DIST | cv2.CALIB_FIX_K3
    _, *one = cv2.calibrateCamera(board, left, size, None, None, flags=flags)[:3]
    _, *two = cv2.calibrateCamera(board, right, size, None, None, flags=flags)[:3]
    flags |= cv2.CALIB_USE_INTRINSIC_GUESS
    found = cv2.stereoCalibrate(board, left, right, *one, *two, size, flags=flags)
    return found[0], float(np.linalg.norm(found[6])), sum(map(len, board))


def main(biprism):
    random = np.random.default_rng(1)
    by_board, by_lattice, partly = [], [], 0
    with tempfile.TemporaryDirectory() as folder:
        scene, picture = Path(folder) / "scene.toml", Path(folder) / "picture.png"
        for _ in range(POSES):
            position = [*random.uniform([-45, -40], [45, 40]).round(1), round(random.uniform(700, 1300), 1)]
            tilt = random.uniform([-25, -25, -40], [25, 25, 40]).round(1)
            scene.write_text(SCENE.format(size=SIZE, square=SQUARE_MM, position=[*map(float, position)], tilt=[*map(float, tilt)]))
            run(biprism, "render", scene, "--out", picture)
            found = halves(run(biprism, "corners", picture, "--scene", scene, "--json"))
            own = halves(run(biprism, "corners", picture, "--json"))
            by_board.append(found)
            by_lattice.append(own)
            partly += min(len(half) for half in found.values()) < 16 * 13
        cameras = re.findall(r"virtual camera at \((\S+),", run(biprism, "check", scene))
    true = abs(float(cameras[1]) - float(cameras[0]))
    print(f"{POSES} poses, {partly} with a part of the board out of view in a half; baseline of the design {true:.4f} mm")
    print("| numbered by | corners | RMS, px | baseline, mm | off by, mm |")
    print("|---|---|---|---|---|")
    off = []
    for name, views in [("the board (--scene)", by_board), ("each half's own lattice", by_lattice)]:
        rms, found, count = baseline_mm(views)
        off.append(abs(found - true))
        print(f"| {name} | {count} | {rms:.4f} | {found:.4f} | {found - true:+.4f} |")
    sys.exit(int(off[0] > MOST_OFF_MM))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--biprism", default="target/release/biprism")
    main(parser.parse_args().biprism)
