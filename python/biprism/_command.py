"""The command ``biprism``, which the package carries."""

from __future__ import annotations

import os
import signal
import sys

from . import _core


def main() -> int:
    """Runs the command with the arguments of this process, and gives its exit code."""
    # Ctrl-C ends the command at once, as it ends one without Python.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    stdout_is_open = sys.stdout is not None
    # A file that is opened must not take the place of a stream that is closed.
    for descriptor in range(3):
        try:
            os.fstat(descriptor)
        except OSError:
            os.open(os.devnull, os.O_RDWR)
    return _core.command(["biprism", *sys.argv[1:]], stdout_is_open)
