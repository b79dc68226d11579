# %% [markdown]
# # Judge my prism
# The flat prism of a scene against the freeform one that is designed from it: what both pictures show, the figures of the report, and
# at each corner how much higher it stands in the left half than in the right one, which a rectified pair has not.

# %%
from __future__ import annotations

import argparse
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import NDArray

import biprism as bp

SCENES = Path(__file__).resolve().parents[2] / "scenes"
SMALL = {"camera.width_px": 480, "camera.height_px": 270, "camera.pixel_pitch_um": 22.0}
FIGURES = [
    ("vertical disparity, RMS", "stereo", "vertical_disparity_rms_px", "px"),
    ("depth error, RMS", "stereo", "depth_error_rms_mm", "mm"),
]


# %%
def table(report: bp.Report) -> str:
    """The figures of each prism, measured in the picture and true."""
    lines = [f"{'':10} {'':26} {'measured':>12} {'true':>12}"]
    for design in report["designs"]:
        for name, part, key, unit in FIGURES:
            value = design[part][key]
            numbers = ["-" if value[kind] is None else f"{value[kind]:.4g}" for kind in ("measured", "true")]
            lines.append(f"{design['name']:10} {name:26} {numbers[0]:>12} {numbers[1]:>12} {unit}")
    return "\n".join(lines)


# %%
def matched(corners: bp.Records) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Positions in px of the corners that both halves show, left and right."""
    halves = [{tuple(c["index"]): c["position_px"] for c in corners[corners["view"] == k]} for k in (0, 1)]
    both = sorted(set(halves[0]) & set(halves[1]))
    left, right = (np.array([half[index] for index in both]).reshape(-1, 2) for half in halves)
    return left, right


# %%
def draw(scenes: dict[str, bp.Scene], path: Path) -> None:
    """Pictures above, vertical disparities below, on one scale."""
    figure, axes = plt.subplots(2, len(scenes), figsize=(12, 7.5), layout="constrained")
    shown = {}
    for (name, scene), (above, below) in zip(scenes.items(), axes.T):
        picture = scene.render(truth=False)
        above.imshow(picture.radiance, cmap="gray", vmin=0, vmax=1)
        above.axvline(scene.size_px[0] / 2 - 0.5, color="tab:orange", lw=0.8)
        above.set(title=f"{name} prism", xticks=[], yticks=[])
        left, right = matched(scene.corners(picture))
        shown[name] = (below, left, left[:, 1] - right[:, 1])
    most = max(np.abs(disparity).max(initial=1e-9) for _, _, disparity in shown.values())
    for name, (below, left, disparity) in shown.items():
        dots = below.scatter(*left.T, c=disparity, cmap="coolwarm", vmin=-most, vmax=most, s=16, edgecolors="0.6", linewidths=0.3)
        rms = np.sqrt(np.mean(disparity**2)) if len(disparity) else float("nan")
        below.set(title=f"{len(disparity)} corners in both halves, {rms:.3g} px RMS", xlabel="x in the left half, px", ylabel="y, px")
        width, height = scenes[name].size_px
        below.set(xlim=(0, width / 2), ylim=(height, 0))
    figure.colorbar(dots, ax=axes[1], label="y left less y right, px")
    figure.savefig(path, dpi=110)


# %%
def main() -> None:
    parser = argparse.ArgumentParser(description="Judges the prism of a scene.")
    parser.add_argument("scene", nargs="?", type=Path, default=SCENES / "paper.toml")
    parser.add_argument("--out", type=Path, default=Path("out"))
    parser.add_argument("--quick", action="store_true", help="on a small sensor")
    args = parser.parse_args()
    args.out.mkdir(parents=True, exist_ok=True)
    scene = bp.Scene.load(args.scene)
    if args.quick:
        scene = scene.replace({**SMALL, "board.columns": 21, "board.rows": 21, "board.square_mm": 20.0})
    print(table(scene.compare()))
    flat = scene.replace({"prism.kind": "flat", "prism.design": None})
    freeform = scene.replace({"prism.kind": "freeform"})
    draw({"flat": flat, "freeform": freeform}, args.out / "judged.png")


if __name__ == "__main__":
    main()
