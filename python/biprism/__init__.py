"""A virtual stereo camera: one camera that looks through a prism, simulated and judged.

    import biprism as bp
    scene = bp.Scene.load("scenes/paper.toml")
    picture = scene.render()                  # picture.radiance, .board, .side
    corners = scene.corners(picture)          # records of bp.CORNER
    report = scene.compare()                  # flat against freeform, as a dict
    thicker = scene.replace({"prism.thickness_mm": 9.0})

Lengths in mm, positions in the image in px: the centre of pixel ``[j, i]`` of an array is at (i + 0.5, j + 0.5). Results have the bits of
the command ``biprism``, which the package carries, whatever the threads (``RAYON_NUM_THREADS``). Long calls release the lock of the
interpreter and end on Ctrl-C. What is wrong with a scene is a SceneError with place, key, rule and next step.
"""

from __future__ import annotations

import os

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._arrays import CORNER, VIEWS, Records, Side, Transfer, picture
from ._errors import SceneError
from ._optiland import to_optiland
from ._results import DesignedPrism, HalfPicture, RectifiedPair, Rendering, Report
from ._scene import Level, Scene, compare

__version__ = _core.VERSION
__all__ = [
    "CORNER", "VIEWS", "DesignedPrism", "HalfPicture", "Level", "Records", "RectifiedPair", "Rendering", "Report", "Scene", "SceneError",
    "Side", "Transfer", "compare", "corners", "read", "read_corners", "to_optiland",
]  # fmt: skip


def corners(image: ArrayLike | Rendering, *, whole: bool = False, transfer: Transfer | None = None) -> Records:
    """The corners of a checkerboard in any picture, of each half by itself, or with ``whole`` in one view.

    ``image`` is (h, w) of linear light as floats, or of uint8 or uint16 as a file stores them, for which ``transfer`` says how they became
    of light. Any strides and byte order will do.

    Records of ``CORNER``, (n,). Each half counts columns and rows from its own first corner: ``Scene.corners`` counts the board's.

    Raises TypeError and ValueError for what is no such picture.
    """
    light = picture(image.radiance if isinstance(image, Rendering) else image, transfer)
    return _core.corners(light, whole)[0].view(CORNER)


def read(path: str | os.PathLike[str], *, transfer: Transfer | None = None) -> NDArray[np.float32]:
    """The picture of a file (PNG, EXR, TIFF, JPEG, BMP or PNM) as linear light, (h, w); of colours their luminance. ``transfer`` is the
    curve where the file states none.

    Raises SceneError where it cannot be read, and where neither file nor ``transfer`` tells the curve.
    """
    return _core.read(path, transfer)


def read_corners(path: str | os.PathLike[str]) -> Records:
    """The corners of a file (.csv, .json, .yml of OpenCV), as records of ``CORNER``, (n,).

    Raises SceneError where it cannot be read.
    """
    return _core.read_corners(path)[0].view(CORNER)
