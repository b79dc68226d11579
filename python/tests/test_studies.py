"""What is found: each function once, held against the command."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import biprism as bp
from conftest import CASES, without_times

FLAT, FREEFORM = CASES / "prism_flat.toml", CASES / "prism_freeform.toml"


def test_corners(flat: bp.Scene, command: Callable[..., Any], tmp_path: Path) -> None:
    picture = flat.render(truth=False)
    command("render", FLAT, "--out", tmp_path / "a.exr")
    for words, found in [([], bp.corners(picture)), (["--scene", FLAT], flat.corners(picture))]:
        command("corners", tmp_path / "a.exr", *words, "--out", tmp_path / "a.csv")
        listed = bp.read_corners(tmp_path / "a.csv")
        for name in ("view", "index", "position_px", "polarity"):
            assert np.array_equal(found[name], listed[name]), name
        assert np.allclose(found["covariance_px2"], listed["covariance_px2"], rtol=1e-12, atol=0)
        assert np.array_equal(found["contrast"], listed["contrast"])
    left, right = (found[found["view"] == k] for k in (0, 1))
    assert left["position_px"][:, 0].max() < 160 < right["position_px"][:, 0].min()
    half = bp.corners(picture.halves()[1].radiance, whole=True)
    assert set(half["view"]) == {2} and len(half) == len(right)
    # The index is that of the board: what is seen there is that corner.
    seen = flat.trace(found["position_px"])
    corner_mm = (found["index"] - 9.5) * 20.0
    assert np.abs(seen["board_mm"] - corner_mm).max() < 0.02


def test_corners_of_another_board_are_told(flat: bp.Scene) -> None:
    moved = flat.replace({"board.position_mm": [9.0, 10.0, 1000.0]})
    with pytest.warns(UserWarning, match="which corners of the board"):
        assert len(flat.corners(moved.render(truth=False))) == 0


@pytest.mark.parametrize("own", [True, False])
def test_measure(own: bool, flat: bp.Scene, command: Callable[..., Any], tmp_path: Path) -> None:
    command("render", FLAT, "--out", tmp_path / "a.exr")
    words = ["--own", "--budget"] if own else []
    told = command("measure", tmp_path / "a.exr", "--scene", FLAT, *words, "--json")
    picture = flat.render()
    found = flat.measure(picture, own=own, budget=own)
    assert without_times(found) == without_times(told)
    assert without_times(flat.measure(np.asfortranarray(picture.radiance), own=own, budget=own)) == without_times(told)
    with pytest.raises(ValueError, match="own=True"):
        flat.measure(picture, budget=True)
    with pytest.raises(ValueError, match="another scene"):
        flat.replace({"prism.index": 1.5}).measure(picture, own=True)


def test_compare(flat: bp.Scene, freeform: bp.Scene, command: Callable[..., Any], tmp_path: Path) -> None:
    told = command("compare", FREEFORM, "--pictures", "none", "--out", tmp_path, "--json")
    assert without_times(freeform.compare()) == without_times(told)
    told = command("compare", FLAT, FREEFORM, "--pictures", "none", "--out", tmp_path, "--json")
    found = bp.compare([flat, freeform])
    assert without_times(found) == without_times(told)
    assert [design["name"] for design in found["designs"]] == ["prism_flat", "prism_freeform"]
    with pytest.raises(bp.SceneError, match="at most 8"):
        bp.compare([flat] * 9)
    with pytest.raises(ValueError, match="no scene"):
        bp.compare([])


def test_trace_and_aim(freeform: bp.Scene, command: Callable[..., Any], tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    px = rng.uniform([0, 0], [320, 180], (5000, 2))
    np.save(tmp_path / "px.npy", px)
    command("trace", FREEFORM, "--points", tmp_path / "px.npy", "--out", tmp_path / "rays.npy")
    rays, told = freeform.trace(px), np.load(tmp_path / "rays.npy")
    assert rays.dtype == told.dtype and rays.tobytes() == told.tobytes()
    seen = rays[rays["class"] < 2]
    assert len(seen) > 4000
    names = np.array(["left", "right"])[seen["side"]]
    back = freeform.aim(names, seen["board_mm"])
    assert (back["seen"] == 1).all() and np.abs(back["pixel_px"] - seen["pixel_px"]).max() < 1e-8
    table = np.column_stack([seen["side"], seen["board_mm"]])
    np.save(tmp_path / "board.npy", table)
    command("trace", FREEFORM, "--back", "--points", tmp_path / "board.npy", "--out", tmp_path / "pixels.npy")
    assert back.tobytes() == np.load(tmp_path / "pixels.npy").tobytes()
    assert freeform.aim("right", [0, 0]).shape == ()
    # In light of one wavelength.
    glass = {"prism.glass": "N-BK7", "prism.index": 1.5168}
    words = [word for key, value in glass.items() for word in ("--set", f"{key}={value}")]
    command("trace", FREEFORM, *words, "--wavelength-nm", 450, "--points", tmp_path / "px.npy", "--out", tmp_path / "blue.npy")
    blue = freeform.replace(glass).trace(px, wavelength_nm=450)
    assert blue.tobytes() == np.load(tmp_path / "blue.npy").tobytes() != rays.tobytes()
    with pytest.raises(bp.SceneError, match="says nothing of other wavelengths"):
        freeform.aim("left", [0, 0], wavelength_nm=450)
    with pytest.raises(ValueError, match="side"):
        freeform.aim("middle", [0, 0])  # type: ignore[arg-type]


def test_design(flat: bp.Scene, freeform: bp.Scene, command: Callable[..., Any], tmp_path: Path) -> None:
    told = command("design", FREEFORM, "--objective", "toed-in", "--degree", 7, "--out", tmp_path, "--json")
    made = freeform.design(objective="toed-in", degree=7)
    assert without_times(made.figures) == without_times(told)
    assert made.prism == (tmp_path / "prism.toml").read_text()
    # The designed prism is the one that is built where the scene asks for a design.
    plain = freeform.replace({"prism.tilt_deg": [0.1, 0.2, 0.3]})
    seen = [scene.trace([[40.0, 30.0], [250.0, 90.0]])["board_mm"] for scene in (plain, plain.design().scene)]
    assert np.abs(seen[0] - seen[1]).max() < 1e-9
    for wrong in ({"objective": "none"}, {"out": "here"}, {"nothing": 1}):
        with pytest.raises(bp.SceneError):
            flat.design(**wrong)
    with pytest.raises(ValueError, match="blank"):
        flat.design(objective="toed-in --out x")


def test_rectify(freeform: bp.Scene, command: Callable[..., Any], tmp_path: Path) -> None:
    told = command("rectify", FREEFORM, "--depth-mm", 700, "--residuals-at-mm", 900, "--out", tmp_path, "--json")
    pair = freeform.rectify(700, residuals_at_mm=[900])
    assert pair.report == told and pair.stereo_yml == (tmp_path / "stereo.yml").read_text()
    for name in ("left_x", "left_y", "right_x", "right_y"):
        values = getattr(pair, name)
        assert values.dtype == np.float32 and values.tobytes() == np.load(tmp_path / f"{name}.npy").tobytes()
    with pytest.raises(ValueError, match="depth"):
        freeform.rectify(-1)


def test_analyse(flat: bp.Scene, command: Callable[..., Any], tmp_path: Path) -> None:
    words = ("analyse", "reprojection", FLAT, "--depth-mm", 800, "--depth-mm", 1200, "--grid", 9)
    told = command(*words, "--out", tmp_path, "--json")
    found = flat.analyse("reprojection", depth_mm=[800, 1200], grid=9)
    assert found["reprojection"] == told["sheets"]["reprojection"]["rows"]
    assert flat.analyse("stereo", depths_mm=[800, 1200])
    for name, options in [("nothing", {}), ("paper", {}), ("layout", {}), ("spot", {"out": "here"})]:
        with pytest.raises(bp.SceneError):
            flat.analyse(name, **options)


def test_a_board_without_squares_has_no_corners(flat: bp.Scene) -> None:
    noise = flat.replace({"board.texture": "noise"})
    picture = noise.render(truth=False)
    for ask in (noise.corners, noise.measure):
        with pytest.raises(bp.SceneError, match="checkerboard"):
            ask(picture)
    with pytest.raises(bp.SceneError, match="checkerboard"):
        noise.compare()
