"""A half in Optiland: the same rays meet the same places."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

import biprism as bp
from conftest import CASES

pytest.importorskip("optiland")
# Optiland's own accuracy, in mm on the board.
AGREE_MM = 1e-6


def turned(degrees: list[float]) -> NDArray[np.float64]:
    """The rotation about the fixed x, then y, then z axis."""
    (a, b, c) = np.radians(degrees)
    x = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
    y = np.array([[np.cos(b), 0, np.sin(b)], [0, 1, 0], [-np.sin(b), 0, np.cos(b)]])
    z = np.array([[np.cos(c), -np.sin(c), 0], [np.sin(c), np.cos(c), 0], [0, 0, 1]])
    return np.asarray(z @ y @ x)


@pytest.mark.parametrize("name", ["prism_flat", "prism_freeform", "board_tilted", "prism_tilted"])
@pytest.mark.parametrize("side", ["left", "right"])
def test_the_same_rays(name: str, side: bp.Side) -> None:
    from optiland.rays import RealRays

    scene = bp.Scene.load(CASES / f"{name}.toml")
    values = scene.values
    width, height = scene.size_px
    x = np.linspace(0.06, 0.44, 13) * width + (width / 2 if side == "right" else 0)
    px = np.stack(np.meshgrid(x, np.linspace(0.03, 0.97, 11) * height), axis=-1).reshape(-1, 2)
    ours = scene.trace(px)
    assert (ours["class"] == (side == "right")).all()

    # The camera is at the origin of the world; Optiland's frame is the prism's.
    prism, board = values["prism"], values["board"]
    none = [0.0, 0.0, 0.0]
    turn, move = turned(prism.get("tilt_deg", none)), np.array(prism.get("position_mm", none))
    directions = np.column_stack([(px - [width / 2, height / 2]) * values["camera"]["pixel_pitch_um"] / 1000, np.full(len(px), 35.0)])
    assert values["camera"]["focal_length_mm"] == 35.0
    directions = directions / np.linalg.norm(directions, axis=1)[:, None] @ turn
    starts = np.broadcast_to(-move @ turn, directions.shape)
    n = len(px)
    lens = bp.to_optiland(scene, side)
    lens.surfaces.trace(RealRays(*starts.T.copy(), *directions.T.copy(), np.ones(n), np.full(n, 0.5876)))
    met = np.column_stack([np.asarray(getattr(lens.surfaces, axis))[-1, :] for axis in "xyz"])
    on_board = (met @ turn.T + move - np.array(board["position_mm"])) @ turned(board.get("tilt_deg", none))
    assert np.abs(on_board[:, :2] - ours["board_mm"]).max() < AGREE_MM


def test_a_prism_that_is_no_polynomial_is_refused() -> None:
    meshes = [path for path in sorted(CASES.glob("*.toml")) if 'kind = "mesh"' in path.read_text()]
    assert meshes
    with pytest.raises(bp.SceneError):
        bp.to_optiland(bp.Scene.load(meshes[0]))


def test_what_no_lens_file_has_is_refused() -> None:
    made = bp.Scene.load(CASES / "effect_manufacture.toml")
    with pytest.raises(bp.SceneError, match="as they are meant to be") as caught:
        bp.to_optiland(made)
    assert caught.value.key == "effect.manufacture"
    bp.to_optiland(made.replace({"effect.manufacture": None}))
