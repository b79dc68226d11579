"""Corners of a board by OpenCV's two detectors."""

import csv
import os
import time

import cv2
import numpy as np

from .common import CAMERA, FOCAL, HEIGHT, PITCH, WIDTH, command, least

# Inner corners of a board that fills the picture: its corners are where a pinhole sees them, by hand.
ACROSS, DOWN, SQUARE_MM, BOARD_MM = 26, 15, 9.5, 1000.0
SCENE = f"""name = "corners"
{CAMERA}[prism]
kind = "none"
[board]
columns = {ACROSS + 1}
rows = {DOWN + 1}
square_mm = {SQUARE_MM}
position_mm = [3.1, -1.7, {BOARD_MM}]
[output]
encoding = "linear"
"""


def truth():
    """Corners in px, pixel (i, j) covering [i, i + 1) x [j, j + 1)."""
    x = 3.1 + (np.arange(ACROSS) - 0.5 * (ACROSS - 1)) * SQUARE_MM
    y = -1.7 + (np.arange(DOWN) - 0.5 * (DOWN - 1)) * SQUARE_MM
    scale = FOCAL / PITCH / BOARD_MM
    return np.stack(np.meshgrid(x * scale + WIDTH / 2, y * scale + HEIGHT / 2), axis=-1).reshape(-1, 2)


def pictures(program, folder):
    """The board without noise and with 2 % of the contrast, each as the path of an 8-bit picture."""
    scene, sharp = os.path.join(folder, "corners.toml"), os.path.join(folder, "sharp16.png")
    with open(scene, "w") as file:
        file.write(SCENE)
    command([program, "render", scene, "--out", sharp])
    light = cv2.imread(sharp, cv2.IMREAD_UNCHANGED) / 65535.0
    noise = np.random.default_rng(1).normal(0.0, 0.02 * (light.max() - light.min()), light.shape)
    for name, values in (("sharp", light), ("2 % noise", light + noise)):
        path = os.path.join(folder, f"{name.split()[0]}.png")
        cv2.imwrite(path, np.clip(np.round(values * 255), 0, 255).astype(np.uint8))
        yield name, path


def by_biprism(program, picture):
    """CPU seconds of the whole command with the reading of the file, and the corners."""
    out = os.path.splitext(picture)[0] + ".csv"
    seconds = command([program, "corners", picture, "--whole", "--transfer", "linear", "--out", out, "--quiet"])
    with open(out) as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    return seconds, np.array([[float(row["x_px"]), float(row["y_px"])] for row in rows])


def by_opencv(picture, sector_based):
    """CPU seconds of the calls alone, on one thread, and the corners; OpenCV's pixel centres are whole numbers."""
    cv2.setNumThreads(1)
    grey = cv2.imread(picture, cv2.IMREAD_GRAYSCALE)
    start = time.process_time()
    if sector_based:
        found, corners = cv2.findChessboardCornersSB(grey, (ACROSS, DOWN), flags=cv2.CALIB_CB_ACCURACY)
    else:
        found, corners = cv2.findChessboardCorners(grey, (ACROSS, DOWN))
        if found:
            ends = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 100, 1e-6)
            corners = cv2.cornerSubPix(grey, corners, (7, 7), (-1, -1), ends)
    seconds = time.process_time() - start
    return seconds, corners.reshape(-1, 2) + 0.5 if found else np.empty((0, 2))


def table(program, folder):
    """Prints corners found, their errors and the time."""
    print(f"{'':44} {'CPU s':>9} {'found':>9} {'RMS px':>9} {'worst px':>9}")
    true = truth()
    for kind, picture in pictures(program, folder):
        detectors = {
            "biprism corners, whole command": lambda: by_biprism(program, picture),
            "OpenCV findChessboardCorners + cornerSubPix": lambda: by_opencv(picture, False),
            "OpenCV findChessboardCornersSB": lambda: by_opencv(picture, True),
        }
        print(f"{kind}, {len(true)} corners")
        for name, detect in detectors.items():
            seconds, corners = least(detect)
            off = np.linalg.norm(corners[:, None] - true[None], axis=2).min(axis=1) if len(corners) else np.full(1, np.nan)
            rms = np.sqrt((off**2).mean())
            print(f"{name:44} {seconds:9.3f} {len(corners):9} {rms:9.1e} {off.max():9.1e}", flush=True)
