"""Pictures: the bits of the command's files."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import biprism as bp
from conftest import CASES

NAMES = ["prism_flat", "prism_freeform", "board_tilted", "sensor_tiny"]


@pytest.mark.parametrize("name", NAMES)
def test_bits_are_those_of_the_command(name: str, command: Callable[..., Any], tmp_path: Path) -> None:
    path = CASES / f"{name}.toml"
    told = command("render", path, "--out", tmp_path / "a.exr", "--out", tmp_path / "a.npy", "--json")
    scene = bp.Scene.load(path)
    made, truth = scene.render(), np.load(tmp_path / "a.npy")
    light = bp.read(tmp_path / "a.exr")
    assert made.radiance.dtype == np.float32 and made.radiance.shape == scene.size_px[::-1]
    assert made.radiance.tobytes() == light.tobytes()
    assert made.board.dtype == np.float64 and made.board.tobytes() == truth["board_mm"].tobytes()
    assert made.side.dtype == np.uint8 and np.array_equal(made.side, truth["class"])
    assert made.account["counts"] == told["counts"] and made.account["accuracy"] == told["accuracy"]
    seen = made.side < 2
    assert seen.any() and np.isnan(made.board_f32[~seen]).all()
    assert np.abs(made.board_f32[seen] - made.board[seen]).max() < 1e-3


def test_a_column_on_the_ridge_is_of_one_side() -> None:
    # Of an odd width: what its rays see is a matter of rounding, and is the same for the map.
    made = bp.Scene.load(CASES / "sensor_bayer.toml").render()
    seen = made.side < 2
    assert np.abs(made.board_f32[seen] - made.board[seen]).max() < 1e-3


@pytest.mark.parametrize("target", ["draft", "exact", 1e-3])
def test_accuracy_is_a_level_or_a_target(target: Any, flat: bp.Scene, command: Callable[..., Any], tmp_path: Path) -> None:
    made = flat.render(accuracy=target, truth=False)
    words = ["--target-px", target] if isinstance(target, float) else ["--set", f"accuracy={target}"]
    command("render", CASES / "prism_flat.toml", *words, "--out", tmp_path / "a.exr")
    assert made.radiance.tobytes() == bp.read(tmp_path / "a.exr").tobytes()
    level = made.account["accuracy"]["level"]
    assert level == target or isinstance(target, float) and made.account["accuracy"]["target_px"] == target
    for wrong in ("fine", 0.0, -1.0, 2.0, float("nan")):
        with pytest.raises(ValueError, match="accuracy"):
            flat.render(accuracy=wrong)  # type: ignore[arg-type]


def test_what_is_not_kept_is_told(flat: bp.Scene) -> None:
    with pytest.warns(UserWarning, match="not kept to 1e-12 px"):
        made = flat.render(1e-12, truth=False)
    assert len(made.account["unmet"]) == 1 and flat.render(1e-3, truth=False).account["unmet"] == []


def test_without_truth_there_is_none(flat: bp.Scene) -> None:
    plain = flat.render(truth=False)
    assert np.array_equal(plain.radiance, flat.render().radiance)
    for name in ("side", "board", "board_f32", "object"):
        with pytest.raises(ValueError, match="truth=True"):
            getattr(plain, name)


def test_halves_are_views(flat: bp.Scene) -> None:
    for width in (320, 321):
        made = flat.replace({"camera.width_px": width}).render()
        left, right = made.halves()
        assert (left.name, right.name) == ("left", "right")
        assert left.radiance.shape == right.radiance.shape == (180, 160)
        for name in ("radiance", "side", "board"):
            whole = getattr(made, name)
            assert np.shares_memory(getattr(left, name), whole) and np.shares_memory(getattr(right, name), whole)
            assert np.array_equal(getattr(right, name)[:, -1], whole[:, -1], equal_nan=name == "board")
            assert np.array_equal(getattr(right, name)[:, 0], whole[:, (width + 1) // 2], equal_nan=name == "board")


def test_objects_and_colours_are_there_where_the_scene_has_them(flat: bp.Scene) -> None:
    made = flat.render()
    assert made.object is None and made.colour is None and made.noise is None
    bayer = bp.Scene.load(CASES / "sensor_bayer.toml").replace({"effect.sensor.demosaic": "bilinear"})
    colour = bayer.render().colour
    assert colour is not None and colour.shape == (*bayer.size_px[::-1], 3)


def test_a_picture_pickles(flat: bp.Scene) -> None:
    again = pickle.loads(pickle.dumps(flat.render()))
    assert again.scene == flat and np.array_equal(again.board, flat.render().board, equal_nan=True)
