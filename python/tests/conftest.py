"""Scenes of the repository, and the command that the package carries."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import biprism as bp

ROOT = Path(__file__).resolve().parents[2]
CASES = ROOT / "scenes" / "cases"


def program() -> str:
    """The command: the one that BIPRISM names, or that of the package."""
    beside = Path(sys.executable).with_name("biprism")
    found = os.environ.get("BIPRISM") or (str(beside) if beside.exists() else shutil.which("biprism"))
    assert found, "the package is installed with its command"
    return found


@pytest.fixture
def command() -> Callable[..., Any]:
    """Runs the command; with --json what it printed."""

    def run(*words: object) -> Any:
        line = [program(), *map(str, words), "--quiet"]
        done = subprocess.run(line, capture_output=True, text=True, check=True)
        return json.loads(done.stdout) if "--json" in line else done.stdout

    return run


@pytest.fixture
def flat() -> bp.Scene:
    return bp.Scene.load(CASES / "prism_flat.toml")


@pytest.fixture
def freeform() -> bp.Scene:
    return bp.Scene.load(CASES / "prism_freeform.toml")


def without_times(report: Any) -> Any:
    """The report with no times in it."""
    if isinstance(report, dict):
        return {key: without_times(value) for key, value in report.items() if key != "timing_s"}
    return [without_times(value) for value in report] if isinstance(report, list) else report
