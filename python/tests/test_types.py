"""Types: mypy --strict takes the package and the notebooks, and notices what is wrong."""

from __future__ import annotations

from pathlib import Path

import biprism
from mypy import api

HERE = Path(__file__).resolve().parents[1]

WRONG = """
import biprism as bp
scene: bp.Scene = bp.Scene.load(3)
scene.render(accuracy=[])
scene.rectify("deep")
value: str = scene.render().radiance
"""
RIGHT = """
import biprism as bp
import numpy as np
from numpy.typing import NDArray
scene: bp.Scene = bp.Scene.load("a").replace({"prism.index": 1.5})
light: NDArray[np.float32] = scene.render("exact").radiance
side: NDArray[np.uint8] = scene.render(1e-3, truth=True).halves()[0].side
names: list[str] = [design["name"] for design in scene.compare()["designs"]]
corners: NDArray[np.void] = bp.corners(light)
"""


def strict(*words: str) -> tuple[str, int]:
    out, err, code = api.run(["--strict", "--config-file", str(HERE / "pyproject.toml"), "--cache-dir=/dev/null", *words])
    return out + err, code


def test_the_installed_package_has_types(tmp_path: Path) -> None:
    assert (Path(biprism.__file__).parent / "py.typed").exists()
    (tmp_path / "right.py").write_text(RIGHT)
    (tmp_path / "wrong.py").write_text(WRONG)
    told, code = strict(str(tmp_path / "right.py"))
    assert code == 0, told
    told, code = strict(str(tmp_path / "wrong.py"))
    lines = {int(line.split(":")[1]) for line in told.splitlines() if ": error:" in line}
    assert code == 1 and lines == {3, 4, 5, 6}, told


def test_sources_and_notebooks_are_strict() -> None:
    told, code = strict(str(HERE / "biprism"), str(HERE / "notebooks"))
    assert code == 0, told
