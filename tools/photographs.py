#!/usr/bin/env python3
"""Holds the detector against OpenCV's two on photographs of a checkerboard that nobody rendered.

    pip install opencv-python-headless==5.0.0.*
    cargo build --release
    python3 tools/photographs.py FOLDER 8x6 [--transfer srgb] [--biprism target/release/biprism] [--keep PATTERN]

FOLDER holds photographs of one board by one camera, 8x6 are the columns and rows of its inner corners. For each photograph
`biprism corners --whole --board`, `findChessboardCorners` with `cornerSubPix`, and `findChessboardCornersSB` with
`CALIB_CB_ACCURACY` are asked. A truth is not at hand: the photographs in which all three find the whole board are calibrated three
times (`calibrateCamera`, five coefficients of distortion), once with each one's corners, and the one whose corners fit one
camera best has the smallest RMS. Printed are

    whole       photographs in which the whole board was found, and corners found in all
    RMS         of the calibration, in px, of the same corners
    to ours     median and largest distance to this detector's corners, in px
    CPU         ms a photograph: OpenCV's in this process without reading the file, this detector's with reading, start and end

and one line for each photograph in which the three differ in what they found.
"""

import argparse
import json
import os
import resource
import subprocess
import sys
import time
from pathlib import Path

import cv2
import numpy as np

ENDINGS = {".jpg", ".jpeg", ".png", ".tif", ".tiff", ".bmp", ".pgm", ".ppm"}
SUBPIX = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 100, 1e-4)
NAMES = ("this eye", "findChessboardCorners", "SB, accuracy")


def own(picture, args):
    """The corners as OpenCV counts pixels, n x 2, and the ms of CPU time."""
    command = [args.biprism, "corners", picture, "--whole", "--json", "--board", args.board]
    command += ["--transfer", args.transfer]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    environment = {**os.environ, "RAYON_NUM_THREADS": "1"}
    run = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if run.returncode != 0:
        print(run.stderr.strip(), file=sys.stderr)
        return np.zeros((0, 2)), 0.0
    corners = json.loads(run.stdout)["halves"][0]["corners"]
    ms = 1e3 * (after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    # Pixel (i, j) has its centre at (i + 0.5, j + 0.5) here, and at (i, j) there.
    points = np.array([c["position_px"] for c in corners]).reshape(-1, 2) - 0.5
    return points, ms


def classic(grey, size):
    flags = cv2.CALIB_CB_ADAPTIVE_THRESH + cv2.CALIB_CB_NORMALIZE_IMAGE
    found, corners = cv2.findChessboardCorners(grey, size, flags=flags)
    if not found:
        return None
    # A window that reaches a third of the way to the next corner, and 11 px at most.
    grid = corners.reshape(size[1], size[0], 2)
    step = min(np.linalg.norm(np.diff(grid, axis=axis), axis=2).min() for axis in (0, 1))
    window = int(np.clip(step / 3, 2, 11))
    return cv2.cornerSubPix(grey, corners, (window, window), (-1, -1), SUBPIX).reshape(-1, 2)


def sector(grey, size):
    found, corners = cv2.findChessboardCornersSB(grey, size, flags=cv2.CALIB_CB_ACCURACY)
    return corners.reshape(-1, 2) if found else None


def timed(detect, grey, size):
    start = time.process_time()
    found = detect(grey, size)
    return found, 1e3 * (time.process_time() - start)


def on_grid(points, reference):
    """`points` in the order of `reference`, each the nearest; `None` where two are the nearest to one."""
    nearest = np.linalg.norm(points[:, None] - reference[None], axis=2).argmin(axis=0)
    return points[nearest] if len(set(nearest)) == len(points) == len(reference) else None


def calibrated(size, views, picture):
    """The RMS of a calibration in px."""
    grid = np.zeros((size[0] * size[1], 3), np.float32)
    grid[:, :2] = np.mgrid[0 : size[0], 0 : size[1]].T.reshape(-1, 2)
    points = [view.astype(np.float32).reshape(-1, 1, 2) for view in views]
    return cv2.calibrateCamera([grid] * len(views), points, picture[::-1], None, None)[0]


def main(args):
    size = tuple(int(n) for n in args.board.split("x"))
    whole = size[0] * size[1]
    pictures = sorted(p for p in Path(args.folder).glob(args.keep) if p.suffix.lower() in ENDINGS)
    if not pictures:
        sys.exit(f"{args.folder} holds no picture that {args.keep} names")
    cv2.setNumThreads(1)
    found, ms, views, shape, differing = [[], [], []], [[], [], []], [[], [], []], None, []
    for picture in pictures:
        grey = cv2.imread(str(picture), cv2.IMREAD_GRAYSCALE | cv2.IMREAD_IGNORE_ORIENTATION)
        if grey is None:
            print(f"{picture} cannot be read", file=sys.stderr)
            continue
        points, own_ms = own(picture, args)
        theirs = [timed(detect, grey, size) for detect in (classic, sector)]
        boards = [points] + [found for found, _ in theirs]
        counts = [0 if board is None else len(board) for board in boards]
        for k, milliseconds in enumerate([own_ms] + [t for _, t in theirs]):
            ms[k].append(milliseconds)
            found[k].append(counts[k])
        if len(set(counts)) > 1:
            differing.append((picture.name, counts))
        if min(counts) == whole and grey.shape == (shape or grey.shape):
            # In the order of one of OpenCV's, which is that of its board.
            ordered = [on_grid(board, boards[1]) for board in boards]
            if all(board is not None for board in ordered):
                shape = grey.shape
                for k, board in enumerate(ordered):
                    views[k].append(board)
    print(f"{args.folder}: {len(pictures)} photographs, board {args.board}, {len(views[0])} calibrated")
    print("| detector | whole | corners | RMS, px | to ours, px: median, largest | CPU, ms |")
    print("|---|---|---|---|---|---|")
    for k, name in enumerate(NAMES):
        apart = [np.linalg.norm(a - b, axis=1) for a, b in zip(views[k], views[0])]
        between = f"{np.median(np.concatenate(apart)):.3f}, {np.concatenate(apart).max():.2f}" if k and apart else "-"
        rms = f"{calibrated(size, views[k], shape):.4f}" if len(views[k]) >= 3 else "-"
        boards = sum(count == whole for count in found[k])
        print(f"| {name} | {boards} | {sum(found[k])} | {rms} | {between} | {np.median(ms[k]):.0f} |")
    for name, counts in differing:
        print(f"{name}: " + ", ".join(f"{n} by {who}" for n, who in zip(counts, NAMES)))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder")
    parser.add_argument("board", help="columns x rows of inner corners, as in 8x6")
    parser.add_argument("--transfer", default="srgb")
    parser.add_argument("--biprism", default="target/release/biprism")
    parser.add_argument("--keep", default="*", help="only photographs of such names, as in 'left*.jpg'")
    main(parser.parse_args())
