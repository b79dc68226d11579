#!/usr/bin/env python3
"""Measures the pictures of `cargo run --release --example corner_table -- FOLDER` with OpenCV's detectors.

    pip install opencv-python-headless==5.0.0.*
    cargo run --release --example corner_table -- /tmp/corners
    python3 tools/compare_corners.py /tmp/corners

Prints a table: RMS distance in px to the true corners, "no" where the detector found no board, and after the slash the
corners found where they are not all. The pictures are 8-bit sRGB, as OpenCV takes them. `FOLDER/NAME.true.yml` and
`FOLDER/NAME.own.yml` are read by `cv2.FileStorage` (pixel centres at integers), the same files that
`biprism corners --out corners.yml` writes.
"""

import sys
from pathlib import Path

import cv2
import numpy as np

INNER = (13, 17)
SUBPIX = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 100, 1e-4)


def corners_of(path):
    """The corners of a file of this crate, n x 2."""
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)
    corners = storage.getNode("whole_corners").mat()
    storage.release()
    return np.zeros((0, 2)) if corners is None else corners.reshape(-1, 2)


def classic(grey, window):
    found, corners = cv2.findChessboardCorners(grey, INNER, flags=cv2.CALIB_CB_ADAPTIVE_THRESH)
    if not found:
        return None
    if window:
        corners = cv2.cornerSubPix(grey, corners, (window, window), (-1, -1), SUBPIX)
    return corners.reshape(-1, 2)


def sector(grey, flags):
    found, corners = cv2.findChessboardCornersSB(grey, INNER, flags=flags)
    return corners.reshape(-1, 2) if found else None


DETECTORS = {
    "findChessboardCorners": lambda grey: classic(grey, 0),
    "+ cornerSubPix 5": lambda grey: classic(grey, 5),
    "+ cornerSubPix 11": lambda grey: classic(grey, 11),
    "SB": lambda grey: sector(grey, 0),
    "SB, accuracy": lambda grey: sector(grey, cv2.CALIB_CB_ACCURACY),
}


def judged(found, true):
    """RMS distance of the found corners to the nearest true ones, and how many there are."""
    if found is None or len(found) == 0:
        return "no"
    distance = np.linalg.norm(found[:, None, :] - true[None, :, :], axis=2).min(axis=1)
    right = distance[distance < 2.0]
    rms = float(np.sqrt((right**2).mean())) if len(right) else float("nan")
    return f"{rms:.4f}" if len(right) == len(true) else f"{rms:.4f} ({len(right)}/{len(true)})"


def main(folder):
    print("| scene | " + " | ".join(DETECTORS) + " | this eye |")
    print("|---" * (len(DETECTORS) + 2) + "|")
    for picture in sorted(folder.glob("*.png")):
        grey = cv2.imread(str(picture), cv2.IMREAD_GRAYSCALE)
        true = corners_of(folder / f"{picture.stem}.true.yml")
        row = [judged(detect(grey), true) for detect in DETECTORS.values()]
        row.append(judged(corners_of(folder / f"{picture.stem}.own.yml"), true))
        print(f"| {picture.stem} | " + " | ".join(row) + " |", flush=True)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(Path(sys.argv[1]))
