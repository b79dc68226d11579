"""Arrays that come in: of any strides and byte order, copied or refused, never misread."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import biprism as bp
from conftest import CASES


def same(a: bp.Records, b: bp.Records) -> bool:
    return a.tobytes() == b.tobytes()


def test_strides_and_byte_order_do_not_matter(flat: bp.Scene) -> None:
    # Tilted, so that no mirror image is the picture itself.
    light = flat.replace({"board.tilt_deg": [3.0, 5.0, 2.0]}).render(truth=False).radiance
    wanted = bp.corners(light)
    assert len(wanted) > 60 and wanted.dtype == bp.CORNER
    wide = np.zeros((180, 640), np.float32)
    wide[:, ::2] = light
    forms = [np.asfortranarray(light), wide[:, ::2], light[::-1][::-1], light.astype(">f4"), light.astype(np.float64)]
    assert all(same(bp.corners(form), wanted) for form in forms)
    flipped = bp.corners(light[::-1])
    assert not same(flipped, wanted) and same(flipped, bp.corners(np.ascontiguousarray(light[::-1])))
    assert same(bp.corners(light.tolist()), wanted)
    frozen = light.copy()
    frozen.flags.writeable = False
    assert same(bp.corners(frozen), wanted)


def test_stored_values_need_their_curve(flat: bp.Scene, tmp_path: Path, command: Callable[..., Any]) -> None:
    command("render", CASES / "prism_flat.toml", "--out", tmp_path / "a.png")
    import cv2

    stored = cv2.imread(str(tmp_path / "a.png"), cv2.IMREAD_UNCHANGED)
    assert stored.dtype == np.uint16
    by_file = bp.corners(bp.read(tmp_path / "a.png"))
    assert same(bp.corners(stored, transfer="srgb"), by_file)
    assert same(bp.corners(stored / 65535.0, transfer="srgb"), by_file)
    assert not same(bp.corners(stored, transfer="linear"), by_file)
    with pytest.raises(TypeError, match="transfer"):
        bp.corners(stored)
    with pytest.raises(ValueError, match="curve"):
        bp.corners(stored, transfer="gamma")  # type: ignore[arg-type]


@pytest.mark.parametrize("kind", [np.int64, np.int32, np.uint32, np.complex64, np.bool_, np.str_, object])
def test_other_types_are_refused(kind: Any) -> None:
    with pytest.raises(TypeError, match="type"):
        bp.corners(np.zeros((50, 60)).astype(kind))


def test_what_is_no_picture_is_refused(flat: bp.Scene) -> None:
    light = flat.render(truth=False).radiance
    for shape in [(), (5,), (0, 4), (4, 4, 3)]:
        with pytest.raises(ValueError, match="shape"):
            bp.corners(np.zeros(shape, np.float32))
    spoilt = light.copy()
    spoilt[3, 4] = np.nan
    with pytest.raises(ValueError, match="finite"):
        bp.corners(spoilt)
    with pytest.raises(ValueError, match="finite"):
        bp.corners(light.astype(np.float64) * 1e300)
    with pytest.raises(TypeError, match="mask"):
        bp.corners(np.ma.masked_greater(light, 0.5))
    with pytest.raises(bp.SceneError, match="320 x 180"):
        flat.corners(light[:-1])


def test_positions_of_any_kind(flat: bp.Scene) -> None:
    grid = np.stack(np.meshgrid(np.arange(0.5, 320, 40), np.arange(0.5, 180, 30)), axis=-1)
    wanted = flat.trace(grid)
    assert wanted.shape == (6, 8) and np.array_equal(wanted["pixel_px"], grid)
    turned = np.asfortranarray(grid)
    for form in (turned, grid.astype(">f8"), grid.astype(np.float32), np.repeat(grid, 2, axis=1)[:, ::2]):
        assert same(flat.trace(form), wanted)
    assert flat.trace([160, 90]).shape == () and flat.trace(np.zeros((0, 2))).shape == (0,)
    assert same(flat.trace(np.array([[7, 9]])), flat.trace([[7.0, 9.0]]))
    for wrong in (np.zeros((4, 3)), np.float64(1)):
        with pytest.raises(ValueError, match="shape"):
            flat.trace(wrong)
    with pytest.raises(ValueError, match="finite"):
        flat.trace([[1.0, np.inf]])
    with pytest.raises(TypeError, match="type"):
        flat.trace([[1j, 2]])


def test_corners_that_are_no_records_are_refused(flat: bp.Scene) -> None:
    found = flat.corners(flat.render(truth=False))
    whole = flat.measure(found)
    other = np.zeros(len(found) * 2, dtype=[("index", ">i8", (2,)), ("position_px", ">f8", (2,)), ("view", "i2"), ("more", "f4")])
    for name in ("index", "position_px", "view"):
        other[name][::2] = found[name]
    of_other = flat.measure(other[::2])
    assert of_other["designs"][0]["halves"].keys() == whole["designs"][0]["halves"].keys()
    with pytest.raises(TypeError, match="records"):
        flat.measure(found[["view", "index"]])
    other["index"][0] = 2**40
    with pytest.raises(ValueError, match="fit"):
        flat.measure(other[::2])
    off = found.copy()
    off["position_px"][0] = (-5, 3)
    with pytest.raises(bp.SceneError, match="must lie in"):
        flat.measure(off)


def test_corners_of_no_one_board_are_refused(flat: bp.Scene) -> None:
    corners = flat.corners(flat.render(truth=False))
    for field, value, rule in [
        ("index", corners["index"][1], "is there twice"),
        ("index", [10**6, 0], "is farther from"),
        ("covariance_px2", [[-1.0, 0.0], [0.0, 1.0]], "covariance"),
        ("covariance_px2", [[np.inf, 0.0], [0.0, 1.0]], "covariance"),
    ]:
        wrong = corners.copy()
        wrong[field][0] = value
        with pytest.raises(bp.SceneError, match=rule):
            flat.measure(wrong)
    wrong = corners.copy()
    wrong["polarity"][0] = 9
    with pytest.raises(ValueError, match="polarity is 9"):
        flat.measure(wrong)
