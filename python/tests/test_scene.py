"""Scenes: where they come from, that they stay, equality, pickling, errors."""

from __future__ import annotations

import copy
import pickle
from pathlib import Path

import numpy as np
import pytest

import biprism as bp
from conftest import CASES


def test_file_text_and_dict_are_the_same_scene(flat: bp.Scene) -> None:
    of_text = bp.Scene((CASES / "prism_flat.toml").read_text())
    of_values = bp.Scene(flat.values)
    assert flat == of_text == of_values
    assert flat.values["camera"]["focal_length_mm"] == 35.0
    assert (flat.name, flat.prism, flat.size_px) == ("prism_flat", "flat", (320, 180))
    assert np.array_equal(of_values.render().radiance, flat.render().radiance)


def test_replace_changes_nothing_of_the_scene(flat: bp.Scene) -> None:
    before = flat.text
    third = 1 / 3 + 1
    changed = flat.replace({"prism.index": third, "board.position_mm[2]": np.float64(800), "board.columns": np.int64(11)})
    assert flat.text == before and changed != flat and flat.replace({}) == flat
    values = changed.values
    assert values["prism"]["index"] == third
    assert values["board"]["position_mm"] == [0, 0, 800] and values["board"]["columns"] == 11
    tilted = flat.replace({"board.tilt_deg": (1.0, 2.0, 3.0)})
    assert tilted.replace({"board.tilt_deg": None}) == flat
    assert flat.replace({"board.position_mm": np.array([0.0, 0.0, 1000.0])}) == flat


def test_a_scene_is_compared_by_its_values(flat: bp.Scene, freeform: bp.Scene) -> None:
    assert flat != freeform and flat != "prism_flat"
    assert bp.Scene("# said\n" + flat.text) == flat
    with pytest.raises(TypeError):
        hash(flat)
    assert "prism_flat" in repr(flat) and "320 x 180" in repr(flat)


def test_pickles_and_copies(flat: bp.Scene) -> None:
    changed = flat.replace({"prism.index": 1.5 + 2**-50})
    for scene in (flat, changed):
        for again in (pickle.loads(pickle.dumps(scene)), copy.copy(scene), copy.deepcopy(scene)):
            assert again == scene and again.text == scene.text and repr(again) == repr(scene)


def test_files_of_a_scene_are_found_from_anywhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Those that a scene names by a relative path, also after it was pickled."""
    import cv2

    cv2.imwrite(str(tmp_path / "grey.png"), np.tile(np.arange(32, dtype=np.uint8) * 8, (32, 1)))
    text = (CASES / "prism_flat.toml").read_text() + '\n[board.texture]\nimage = "grey.png"\nwidth_mm = 300.0\n'
    (tmp_path / "named.toml").write_text(text)
    monkeypatch.chdir(tmp_path)
    scene = bp.Scene.load("named.toml")
    kept = pickle.dumps(scene.replace({"prism.index": 1.5}))
    monkeypatch.chdir("/")
    assert pickle.loads(kept) == scene.replace({"prism.index": 1.5})
    assert bp.Scene(text, folder=tmp_path) == scene
    with pytest.raises(bp.SceneError, match="grey.png"):
        bp.Scene(text)


def test_errors_have_a_place(tmp_path: Path, flat: bp.Scene) -> None:
    path = tmp_path / "wrong.toml"
    path.write_text(flat.text.replace("square_mm = 20.0", "square_mm = -1"))
    with pytest.raises(bp.SceneError) as caught:
        bp.Scene.load(path)
    error = caught.value
    line = next(k for k, line in enumerate(path.read_text().splitlines(), 1) if "square_mm" in line)
    assert (error.path, error.line, error.column, error.key) == (str(path), line, 13, "board.square_mm")
    assert "must be" in error.rule and error.help and f"{path.name}:{line}:13" in str(error)
    assert isinstance(error, ValueError)
    again = pickle.loads(pickle.dumps(error))
    assert str(again) == str(error) and vars(again) == vars(error)


def test_errors_of_values_have_a_key(flat: bp.Scene) -> None:
    for change, key in [({"board.square_mm": -1}, "board.square_mm"), ({"board.nothing": 1}, "board.nothing")]:
        with pytest.raises(bp.SceneError) as caught:
            flat.replace(change)
        assert caught.value.key == key and caught.value.line is None
    with pytest.raises(bp.SceneError):
        bp.Scene({"camera": {}})
    with pytest.raises(bp.SceneError, match="finite"):
        flat.replace({"prism.index": float("nan")})
    with pytest.raises(TypeError, match="complex"):
        flat.replace({"prism.index": 1j})
    with pytest.raises(TypeError, match="Scene.load"):
        bp.Scene(CASES)  # type: ignore[arg-type]
    with pytest.raises(bp.SceneError) as caught:
        bp.Scene.load("/nowhere/scene.toml")
    assert caught.value.path == "/nowhere/scene.toml" and caught.value.line is None


def test_values_that_are_none_have_a_key(flat: bp.Scene) -> None:
    with pytest.raises(bp.SceneError) as caught:
        flat.replace({"prism.thickness_mm": 8.0, "prism.index": float("nan")})
    assert caught.value.key == "prism.index"
    with pytest.raises(TypeError, match="a dict by their keys, not str"):
        flat.replace("prism.index=1")  # type: ignore[arg-type]
