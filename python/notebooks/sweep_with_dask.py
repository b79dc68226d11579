# %% [markdown]
# # Sweep with Dask
# What the index of the glass does to a prism: a scene a value, each compared by a worker of a cluster. A scene pickles as its text, and what
# goes wrong with one is told in its place; other tasks go on.

# %%
from __future__ import annotations

import argparse
import os
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import biprism as bp

CASES = Path(__file__).resolve().parents[2] / "scenes" / "cases"
Figures = dict[str, float | None]


# %%
def judged(scene: bp.Scene, index: float) -> Figures | str:
    """Vertical disparity of the flat and of the freeform prism, in px RMS, or what is wrong."""
    try:
        report = scene.replace({"prism.index": index}).compare()
    except bp.SceneError as error:
        return error.rule
    return {design["name"]: design["stereo"]["vertical_disparity_rms_px"]["true"] for design in report["designs"]}


# %%
def swept(scene: bp.Scene, indices: list[float]) -> list[Figures | str]:
    """The figures at each index, in their order, by two processes on this machine; a real cluster gives its address to `Client`."""
    from distributed import Client, LocalCluster

    # A worker does one scene at a time, on one thread: scenes are enough to keep all of them busy.
    os.environ["RAYON_NUM_THREADS"] = "1"
    cluster = LocalCluster(n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=None)
    with cluster, Client(cluster) as client:
        return list(client.gather(client.map(judged, [scene] * len(indices), indices)))


# %%
def draw(indices: list[float], found: list[Figures | str], path: Path) -> None:
    """The figure over the index."""
    figure, axis = plt.subplots(figsize=(7, 4.5), layout="constrained")
    for name in ("flat", "freeform"):
        values = [(n, one[name]) for n, one in zip(indices, found) if not isinstance(one, str)]
        axis.semilogy(*np.array(values, dtype=float).T, "o-", ms=4, label=name)
    axis.set(xlabel="index of the glass", ylabel="vertical disparity, px RMS", title="What the index does to a prism")
    axis.grid(alpha=0.3)
    axis.legend()
    figure.savefig(path, dpi=110)


# %%
def main() -> None:
    parser = argparse.ArgumentParser(description="Sweeps the index of a prism over a cluster.")
    parser.add_argument("scene", nargs="?", type=Path, default=CASES / "prism_flat.toml")
    parser.add_argument("--out", type=Path, default=Path("out"))
    parser.add_argument("--quick", action="store_true", help="6 values")
    args = parser.parse_args()
    args.out.mkdir(parents=True, exist_ok=True)
    indices = [float(index) for index in np.linspace(1.44, 1.72, 6 if args.quick else 29)]
    found = swept(bp.Scene.load(args.scene), indices)
    for index, one in zip(indices, found):
        print(f"{index:.3f}  {one}")
    draw(indices, found, args.out / "swept.png")


if __name__ == "__main__":
    main()
