# %% [markdown]
# # Calibrate with OpenCV on a set
# Pictures of a board at many places through one prism, their corners into `cv2.stereoCalibrate`, and its baseline against the one that the
# prism has. Once with the corners as they are in the halves, and once moved to where the rectified pair has them: the halves of this prism
# are two pinholes but for a known shift of each row.

# %%
from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import cv2
import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import NDArray

import biprism as bp

SCENES = Path(__file__).resolve().parents[2] / "scenes"
SMALL = {"camera.width_px": 960, "camera.height_px": 540, "camera.pixel_pitch_um": 11.0}
Points = NDArray[np.float64]
View = tuple[NDArray[Any], Points, Points]
# Corners of a pose that both halves must show.
FEWEST = 20
STOP = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 500, 1e-14)
PINHOLE = cv2.CALIB_ZERO_TANGENT_DIST | cv2.CALIB_FIX_K1 | cv2.CALIB_FIX_K2 | cv2.CALIB_FIX_K3


# %%
def poses(scene: bp.Scene, count: int) -> list[bp.Scene]:
    """The scene with its board at places drawn at random."""
    rng = np.random.default_rng(1)
    tilt = rng.uniform(-35, 35, (count, 3))
    depth = rng.uniform(700, 1400, count)
    place = np.column_stack([rng.uniform(-20, 20, count), rng.uniform(-20, 20, count), depth])
    return [scene.replace({"board.position_mm": p, "board.tilt_deg": t}) for p, t in zip(place, tilt)]


# %%
def seen(scene: bp.Scene) -> View:
    """Indices of the corners that both halves show, and their places in the picture in OpenCV's px, left and right."""
    corners = scene.corners(scene.render(truth=False))
    halves = [{tuple(c["index"]): c["position_px"] - 0.5 for c in corners[corners["view"] == k]} for k in (0, 1)]
    both = sorted(set(halves[0]) & set(halves[1]))
    left, right = (np.array([half[index] for index in both]).reshape(-1, 2) for half in halves)
    return np.array(both).reshape(-1, 2), left, right


# %%
def sampled(plane: NDArray[np.float32], at: Points) -> Points:
    """A map between its pixels."""
    low = np.clip(np.floor(at).astype(int), 0, np.array(plane.shape[::-1]) - 2)
    (x, y), (s, t) = low.T, (at - low).T
    rows = [(1 - s) * plane[y + k, x] + s * plane[y + k, x + 1] for k in (0, 1)]
    return np.asarray((1 - t) * rows[0] + t * rows[1], np.float64)


def rectified(points: Points, x: NDArray[np.float32], y: NDArray[np.float32], first_column: int) -> Points:
    """Where the rectified image shows what the picture shows at these places: the maps backwards."""
    own = points - [first_column, 0]
    for _ in range(8):
        own = own + points - np.column_stack([sampled(x, own), sampled(y, own)])
    return own


# %%
def calibrate(views: list[View], size: tuple[int, int], square_mm: float) -> tuple[float, float, Points, Points]:
    """Baseline in mm, reprojection error in px RMS, and of the left half the corners and their residuals, in px."""
    board = [np.column_stack([index * square_mm, np.zeros(len(index))]).astype(np.float32) for index, _, _ in views]
    left, right = ([view[k].astype(np.float32) for view in views] for k in (1, 2))
    alone: Any = cv2.calibrateCamera  # its types do not take the None that its manual gives
    (_, matrix, distortion, turns, moves), (_, *inner, _, _) = (
        alone(board, half, size, None, None, flags=PINHOLE, criteria=STOP)[:5] for half in (left, right)
    )
    flags = PINHOLE | cv2.CALIB_USE_INTRINSIC_GUESS
    pair = cv2.stereoCalibrate(board, left, right, matrix, distortion, inner[0], inner[1], size, flags=flags, criteria=STOP)
    shown = [cv2.projectPoints(b, r, t, matrix, distortion)[0].reshape(-1, 2) for b, r, t in zip(board, turns, moves)]
    corners = np.concatenate(left).astype(np.float64)
    return float(np.linalg.norm(pair[6])), float(pair[0]), corners, corners - np.concatenate(shown)


# %%
def draw(picture: NDArray[np.float32], found: dict[str, tuple[Points, Points]], path: Path) -> None:
    """A picture of the set, and the residuals of the left half, each on a scale of its own."""
    figure, axes = plt.subplots(1, 1 + len(found), figsize=(15, 4.6), layout="constrained", width_ratios=[1.7, 1, 1])
    axes[0].imshow(picture, cmap="gray", vmin=0, vmax=1)
    axes[0].set(title="a picture of the set", xticks=[], yticks=[])
    for axis, (name, (corners, residuals)) in zip(axes[1:], found.items()):
        rms = np.sqrt(np.mean(np.sum(residuals**2, axis=1)))
        axis.quiver(*corners.T, *residuals.T, angles="xy", scale_units="xy", scale=rms / 25, width=0.002)
        title = f"left half alone, {name}:\n{rms:.1e} px RMS from a pinhole\narrows {25 / rms:,.0f} times as long"
        axis.set(title=title, xlabel="x, px", ylabel="y, px", aspect="equal")
        axis.set(xlim=(0, picture.shape[1] / 2), ylim=(picture.shape[0], 0))
    figure.savefig(path, dpi=110)


# %%
def main() -> None:
    parser = argparse.ArgumentParser(description="Calibrates a stereo pair on pictures through a prism.")
    parser.add_argument("scene", nargs="?", type=Path, default=SCENES / "exact.toml")
    parser.add_argument("--poses", type=int, default=30)
    parser.add_argument("--out", type=Path, default=Path("out"))
    parser.add_argument("--quick", action="store_true", help="8 poses on a small sensor")
    args = parser.parse_args()
    args.out.mkdir(parents=True, exist_ok=True)
    scene = bp.Scene.load(args.scene)
    if args.quick:
        scene = scene.replace({**SMALL, "board.columns": 21, "board.rows": 21, "board.square_mm": 20.0})
    width, height = scene.size_px
    columns, square_mm = (width + 1) // 2, scene.values["board"]["square_mm"]
    taken = poses(scene, 8 if args.quick else args.poses)
    views = [view for view in map(seen, taken) if len(view[0]) >= FEWEST]

    # Where the rectified pair has them.
    pair = scene.rectify()
    maps = [(pair.left_x, pair.left_y, 0), (pair.right_x, pair.right_y, columns)]
    plain = [(index, left, right - [columns, 0]) for index, left, right in views]
    moved = [(index, rectified(left, *maps[0]), rectified(right, *maps[1])) for index, left, right in views]
    true_mm = pair.report["baseline_mm"]
    print(f"{len(views)} of {len(taken)} poses show {FEWEST} corners in both halves; the baseline is {true_mm:.6f} mm")
    found = {}
    for name, kind in (("as it is", plain), ("rectified", moved)):
        baseline_mm, rms_px, corners, residuals = calibrate(kind, (width // 2, height), square_mm)
        print(f"{name:10} baseline {baseline_mm:.6f} mm, off by {baseline_mm - true_mm:+.6f} mm; RMS {rms_px:.2e} px")
        found[name] = (corners, residuals)
    draw(taken[0].render(truth=False).radiance, found, args.out / "calibrated.png")


if __name__ == "__main__":
    main()
