#!/usr/bin/env python3
"""Calibrates the stereo pair of a data set with OpenCV, and holds its baseline against the designed one.

    pip install opencv-python-headless==5.0.0.*
    biprism dataset scenes/exact.toml --poses 30 --seed 1 --detect --out set
    python3 tools/calibrate_dataset.py set

The corners that both halves show go into `cv2.calibrateCamera` and `cv2.stereoCalibrate`: the true ones, and the detected ones where the
set has them. Each as they are, and with the rows shifted back where that brings the halves nearer to their pinholes, which `cameras.yml`
tells (an exact prism, and nearly the design paper's). Printed are the baseline, what it is off from the distance of the designed cameras
in `cameras.yml`, and the reprojection error. Exit code 1 where the last baseline by true corners is off by more than --most-off-mm.
"""

import argparse
import csv
import json
import sys
from pathlib import Path

try:
    import cv2
    import numpy as np
except ImportError as missing:
    sys.exit(f"{missing}: pip install opencv-python-headless==5.0.0.*")

# Corners of a pose that both halves must show.
FEWEST = 12
# Poses that a calibration takes at most: beyond some dozen they only cost time.
MOST_POSES = 60
STOP = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 500, 1e-14)
PINHOLE = cv2.CALIB_ZERO_TANGENT_DIST | cv2.CALIB_FIX_K1 | cv2.CALIB_FIX_K2 | cv2.CALIB_FIX_K3


def corners(path, first_column):
    """The corners of both halves by (column, row), each in the half's own px of OpenCV."""
    halves = {"left": {}, "right": {}}
    rows = (line for line in path.read_text().splitlines() if not line.startswith("#"))
    for row in csv.DictReader(rows):
        shift = first_column if row["half"] == "right" else 0
        place = (float(row["x_px"]) - 0.5 - shift, float(row["y_px"]) - 0.5)
        halves[row["half"]][int(row["column"]), int(row["row"])] = place
    return halves


def shifted_back(points, shift):
    """Points of a half without the shift of their rows, b (sqrt(1 + s^2) - 1) with s = (y - middle) / f."""
    if shift is None:
        return points
    amplitude, focal, middle = shift
    slope = (points[:, 1] - middle) / focal
    return points - np.stack([amplitude * (np.hypot(1, slope) - 1), np.zeros(len(points))], axis=1)


def calibrate(views, size, shifts, square_mm, flags):
    """Baseline and reprojection error by the corners that both halves show."""
    board, seen = [], ([], [])
    for view in views:
        both = sorted(set(view["left"]) & set(view["right"]))
        if len(both) < FEWEST:
            continue
        board.append(np.array([(i * square_mm, j * square_mm, 0) for i, j in both], np.float32))
        for k, half in enumerate(("left", "right")):
            points = np.array([view[half][index] for index in both])
            seen[k].append(shifted_back(points, shifts[k]).astype(np.float32))
    if len(board) < 4:
        sys.exit(f"{len(board)} poses show {FEWEST} corners in both halves, and 4 are the fewest: make more, or larger boards")
    single = [cv2.calibrateCamera(board, own, size, None, None, flags=flags, criteria=STOP) for own in seen]
    intrinsics = [value for _, matrix, distortion, *_ in single for value in (matrix, distortion)]
    found = cv2.stereoCalibrate(board, *seen, *intrinsics, size, flags=flags | cv2.CALIB_USE_INTRINSIC_GUESS, criteria=STOP)
    return float(np.linalg.norm(found[6])), float(found[0]), len(board), float(found[1][0, 0])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--most-off-mm", type=float, default=0.01)
    parser.add_argument("--distortion", action="store_true", help="let OpenCV fit k1, k2, p1, p2, k3 as well")
    args = parser.parse_args()

    # Read what the set is.
    head, *poses = map(json.loads, (args.folder / "manifest.jsonl").read_text().splitlines())
    file = cv2.FileStorage(str(args.folder / "cameras.yml"), cv2.FILE_STORAGE_READ)
    designed = float(np.linalg.norm(file.getNode("T").mat()))
    size = tuple(int(file.getNode(f"image_{side}").real()) for side in ("width", "height"))
    first_column = int(file.getNode("right_half_first_column").real())
    rows = [file.getNode(f"row_shift_{half}").mat() for half in ("left", "right")]
    rows = [None if row is None else row.ravel() for row in rows]
    raw, undone = (file.getNode(key).mat() for key in ("deviation", "deviation_with_rows_shifted_back"))
    helps = undone is not None and undone[:, 1].max() < 0.5 * raw[:, 1].max()
    try:
        import tomllib
        square_mm = float(tomllib.loads(head["scene_text"])["board"]["square_mm"])
    except ImportError:
        sys.exit("Python 3.11 or newer is needed, for tomllib")

    # Calibrate by each kind of corners.
    print(f"designed baseline {designed:.6f} mm, {len(poses)} poses of {head['scene']}")
    flags = 0 if args.distortion else PINHOLE
    off = None
    for kind in ("corners", "detected"):
        paths = [args.folder / f"{pose['pose']:06}_{kind}.csv" for pose in poses[:MOST_POSES]]
        if not all(path.exists() for path in paths):
            continue
        views = [corners(path, first_column) for path in paths]
        name = "true" if kind == "corners" else "detected"
        for shifts, how in [((None, None), "as they are"), (rows, "rows shifted back")]:
            if how != "as they are" and not helps:
                continue
            baseline, rms, used, focal = calibrate(views, size, shifts, square_mm, flags)
            print(f"{name:8} corners, {how:17}: baseline {baseline:.6f} mm, off by {baseline - designed:+.6f} mm;"
                  f" RMS {rms:.2e} px over {used} poses; f_x {focal:.3f} px")
            if name == "true":
                off = abs(baseline - designed)
    if off is None or off > args.most_off_mm:
        sys.exit(f"the baseline is off by more than {args.most_off_mm} mm")


if __name__ == "__main__":
    main()
