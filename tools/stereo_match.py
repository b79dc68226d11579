#!/usr/bin/env python3
"""Matches the halves of pictures of noise with OpenCV's StereoSGBM: as they are, and after the maps of `biprism rectify`.

    pip install opencv-python-headless==5.0.0.*
    cargo build --release
    python3 tools/stereo_match.py [--biprism target/release/biprism] [--depths-mm 600,1000,2000] [--out DIR]

For the flat, the freeform and the exact prism of the design paper's instrument a board of band-limited noise is rendered at each
depth, with its truth. Printed are, as rows of Markdown: how many of the pixels that both halves see get a disparity (density), how
many of these are off by more than 0.5 and 1 px, the vertical disparity, and the error of the depth: half and 95 % of the matched
pixels are within it, and 95 % of the same pixels of a perfect matcher are. Raw depths are f b/(d - d0) of the virtual cameras that
the halves are designed to be, those after the maps of their own pair; the maps are right at 1000 mm. Pixels within 8 px of the border
of what both halves see are left out. With --out the disparities of the flat and the exact prism and their errors are written as PNG.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

try:
    import cv2
    import numpy as np
except ImportError as missing:
    sys.exit(f"{missing}: pip install opencv-python-headless")

SIZE = (1920, 1080)
MAP_DEPTH_MM = 1000
# Of StereoSGBM: 3-way, block of 5, and a left-right check of 1 px.
BLOCK, P1, P2, UNIQUE, CHECK = 5, 200, 800, 10, 1
BORDER_PX = 8
CAMERA = f"""[camera]
focal_length_mm = 35.0
width_px = {SIZE[0]}
height_px = {SIZE[1]}
pixel_pitch_um = 5.5
"""
GLASS = "index = 1.48\nridge_distance_mm = 78.472\nthickness_mm = 8.545\n"
PRISMS = {
    "flat": f'[prism]\nkind = "flat"\n{GLASS}',
    "freeform": f'[prism]\nkind = "freeform"\n{GLASS}',
    "exact": f'[prism]\nkind = "freeform"\n{GLASS}[prism.design]\nobjective = "epipolar"\nrear = "even"\ndegree = 7\n',
}


def run(*command):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}\n{done.stderr}")
    return done.stdout


def scene(prism, depth_mm):
    """Noise that is as fine in the picture at every depth, and reaches beyond the view."""
    scale = depth_mm / 1000
    board = (
        f"[board]\ncolumns = 51\nrows = 41\nsquare_mm = {10 * scale}\nposition_mm = [0.0, 0.0, {depth_mm}.0]\n"
        f'texture = {{ pattern = "noise", finest_mm = {0.6 * scale} }}\n'
    )
    return f'name = "{prism}"\n{CAMERA}{PRISMS[prism]}{board}'


def matched(left, right, low, high):
    """The disparities x_L - x_R of the left image's pixels; NaN where there is none."""
    least = 16 * int(np.floor(low / 16)) - 16
    count = 16 * int(np.ceil((high - least) / 16)) + 16
    matcher = cv2.StereoSGBM_create(
        minDisparity=least, numDisparities=count, blockSize=BLOCK, P1=P1, P2=P2, disp12MaxDiff=CHECK,
        uniquenessRatio=UNIQUE, mode=cv2.STEREO_SGBM_MODE_SGBM_3WAY,
    )
    found = matcher.compute(left, right).astype(np.float64) / 16
    return np.where(found >= least, found, np.nan)


def figures(found, true, z_mm, vertical, pair):
    """A row of the table, the error of the disparity, and how many pixels are matched."""
    depth = lambda d: pair["focal_px"] * pair["baseline_mm"] / (d - pair["offset_px"]) + pair["centres_ahead_mm"]
    seen = cv2.erode(np.isfinite(true).astype(np.uint8), np.ones((2 * BORDER_PX + 1,) * 2), borderValue=0) > 0
    both = seen & np.isfinite(found)
    error = found - true
    off = np.abs(error[both])
    real, perfect = (100 * np.abs(depth(d[both]) / z_mm[both] - 1) for d in (found, true))
    cells = [
        f"{100 * both.sum() / seen.sum():.1f} %", f"{100 * (off > 0.5).mean():.2f} %", f"{100 * (off > 1).mean():.2f} %",
        f"{np.sqrt(np.mean(vertical[both] ** 2)):.3f}" if vertical is not None else "-",
        *(f"{np.percentile(real, q):.3f} %" for q in (50, 95)), f"{np.percentile(perfect, 95):.2g} %",
    ]
    return cells, np.where(both, error, np.nan)


def painted(values, low, high):
    """Values as colours, what there is not in black."""
    scaled = np.clip(255 * (values - low) / (high - low), 0, 255)
    colours = cv2.applyColorMap(np.nan_to_num(scaled).astype(np.uint8), cv2.COLORMAP_VIRIDIS)
    colours[~np.isfinite(values)] = 0
    return colours


def pairs_of(biprism):
    """The pairs of pinholes that depths are taken by, by prism and name."""
    with tempfile.TemporaryDirectory() as folder:
        text = Path(folder) / "scene.toml"
        text.write_text(scene("flat", MAP_DEPTH_MM))
        told = run(biprism, "analyse", "stereo", text, "--fit-depth-mm", MAP_DEPTH_MM, "--out", folder, "--json")
    return {(row["prism"], row["pair"]): row for row in json.loads(told)["sheets"]["stereo_pairs"]["rows"]}


def study(biprism, prism, depth_mm, pairs, folder):
    """Rows of the table by treatment, with disparities and their errors."""
    text = folder / f"{prism}.toml"
    text.write_text(scene(prism, depth_mm))
    run(biprism, "render", text, "--stereo", "--halves", "--out", folder / "a.png", "--out", folder / "a.npy")
    run(biprism, "rectify", text, "--depth-mm", MAP_DEPTH_MM, "--out", folder / "maps")

    # As they are.
    left, right = (cv2.imread(str(folder / f"a_{half}.png"), cv2.IMREAD_GRAYSCALE) for half in ("left", "right"))
    truth = np.load(folder / "a_left.npy")
    disparity, z_mm = truth["disparity_px"], truth["Z_mm"]
    true = disparity[..., 0]
    found = matched(left, right, np.nanmin(true), np.nanmax(true))
    yield "raw", figures(found, true, z_mm, disparity[..., 1], pairs[prism, "designed"]), found

    # After the maps.
    picture = np.hstack([left, right])
    maps = {name: np.load(folder / "maps" / f"{name}.npy") for name in ("left_x", "left_y", "right_x", "right_y")}
    remap = lambda image, half: cv2.remap(image, maps[f"{half}_x"], maps[f"{half}_y"], cv2.INTER_LANCZOS4)
    left, right = (remap(picture, half) for half in ("left", "right"))
    depth = cv2.remap(z_mm.astype(np.float32), maps["left_x"], maps["left_y"], cv2.INTER_LINEAR, borderValue=np.nan)
    pair = pairs[prism, "map"]
    true = pair["focal_px"] * pair["baseline_mm"] / (depth.astype(np.float64) - pair["centres_ahead_mm"]) + pair["offset_px"]
    columns = np.arange(true.shape[1]) - true
    seen = (columns >= 0) & (columns < true.shape[1]) & (maps["left_x"] >= 0)
    true = np.where(seen, true, np.nan)
    found = matched(left, right, np.nanmin(true), np.nanmax(true))
    yield "map", figures(found, true, depth, None, pair), found


def main(arguments):
    pairs = pairs_of(arguments.biprism)
    print("| board at | prism | halves | density | bad > 0.5 px | bad > 1 px | vertical RMS px | depth error p50 | p95 | p95 of a perfect matcher |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    for depth_mm in arguments.depths_mm:
        for prism in PRISMS:
            with tempfile.TemporaryDirectory() as folder:
                for treatment, (cells, error), found in study(arguments.biprism, prism, depth_mm, pairs, Path(folder)):
                    print(f"| {depth_mm} mm | {prism} | {treatment} | " + " | ".join(cells) + " |", flush=True)
                    if arguments.out and prism != "freeform":
                        arguments.out.mkdir(parents=True, exist_ok=True)
                        low, high = np.nanpercentile(found, [1, 99])
                        middle, half = 0.5 * (low + high), max(0.5 * (high - low), 4)
                        both = np.hstack([painted(found, middle - half, middle + half), painted(error, -2, 2)])
                        cv2.imwrite(str(arguments.out / f"{prism}_{treatment}_{depth_mm}.png"), both)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--biprism", default="target/release/biprism")
    parser.add_argument("--depths-mm", type=lambda text: [int(word) for word in text.split(",")], default=[600, 1000, 2000])
    parser.add_argument("--out", type=Path)
    main(parser.parse_args())
