"""The notebooks run, and leave pictures."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

NOTEBOOKS = Path(__file__).resolve().parents[1] / "notebooks"
PICTURES = {"judge_my_prism": "judged.png", "calibrate_with_opencv": "calibrated.png", "sweep_with_dask": "swept.png"}


def test_all_are_here() -> None:
    assert {path.stem for path in NOTEBOOKS.glob("*.py")} == set(PICTURES)


@pytest.mark.parametrize("name", PICTURES)
def test_a_notebook(name: str, tmp_path: Path) -> None:
    line = [sys.executable, str(NOTEBOOKS / f"{name}.py"), "--out", str(tmp_path), "--quick"]
    done = subprocess.run(line, capture_output=True, text=True, env={**os.environ, "MPLBACKEND": "agg"}, timeout=300)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / PICTURES[name]).stat().st_size > 10_000
    print(done.stdout)
