"""The command that the package carries."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import biprism as bp
from conftest import CASES, ROOT

SCRIPT = Path(sys.executable).with_name("biprism")
MODULE = [sys.executable, "-m", "biprism"]


def run(*words: object, line: list[str] | None = None) -> subprocess.CompletedProcess[str]:
    return subprocess.run([*(line or [str(SCRIPT)]), *map(str, words)], capture_output=True, text=True, cwd=ROOT)


def test_it_is_the_command() -> None:
    for line in ([str(SCRIPT)], MODULE):
        told = run("-V", line=line)
        assert (told.returncode, told.stdout) == (0, f"biprism {bp.__version__}\n")
    assert "Usage: biprism" in run("--help").stdout


def test_exit_codes(tmp_path: Path) -> None:
    scene = CASES / "prism_flat.toml"
    assert run("check", scene).returncode == 0
    unmet = run("corners", "--scene", scene, tmp_path / "none.png")
    assert unmet.returncode == 2 and unmet.stderr.startswith("error: ")
    assert run("no-verb").returncode == 2 and run("render", scene).returncode == 2
    wrong = run("check", scene, "--set", "prism.index=-1")
    assert wrong.returncode == 2 and "prism.index" in wrong.stderr and wrong.stdout == ""
    far = scene.read_text() + '\n[[expect]]\nvalue = "flat/stereo/vertical_disparity_rms_px/true"\nmax = 1e-9\n'
    (tmp_path / "far.toml").write_text(far)
    told = run("compare", tmp_path / "far.toml", "--pictures", "none", "--out", tmp_path)
    assert told.returncode == 1, told.stderr


def test_a_closed_stdout_is_told() -> None:
    line = f'"{SCRIPT}" check "{CASES / "prism_flat.toml"}" --json >&-'
    told = subprocess.run(["sh", "-c", line], capture_output=True, text=True)
    assert told.returncode == 2 and "stdout" in told.stderr
