"""What a scene makes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import _core

if TYPE_CHECKING:
    from ._scene import Scene

Report = dict[str, Any]
Accuracy = tuple[str | None, float | None]


@dataclass(frozen=True, eq=False)
class Rendering:
    """A picture of a scene, and what is true of its pixels. Arrays are rows by columns; the centre of pixel ``[j, i]`` is at
    (i + 0.5, j + 0.5) px."""

    scene: Scene
    """The scene that it shows."""
    radiance: NDArray[np.float32]
    """(h, w): mean radiance over each pixel, of full scale 1; what the scene's sensor makes of it, where it has one."""
    account: Report
    """What was promised of the positions in the picture, in px, what was found, and how much work it was."""
    colour: NDArray[np.float32] | None
    """(h, w, 3): red, green and blue, where the scene's sensor tells them apart."""
    noise: NDArray[np.float32] | None
    """(h, w): standard error of the radiance, where random sets of samples tell it."""
    _accuracy: Accuracy
    _truth: dict[str, NDArray[Any]]

    def _of_truth(self, name: str) -> NDArray[Any]:
        if name not in self._truth:
            raise ValueError(f"the picture has no {name!r}: render with truth=True")
        return self._truth[name]

    @property
    def side(self) -> NDArray[np.uint8]:
        """(h, w): what became of each pixel's centre ray: 0 it sees the board's plane through the left side, 1 through the right one;
        2 missed, 3 reflected totally, 4 not converged, 5 past the board, 6 clipped."""
        return self._of_truth("side")

    @property
    def board_f32(self) -> NDArray[np.float32]:
        """(h, w, 2): the place on the board that each pixel's centre sees, in mm, by the map of the picture, as in an EXR; NaN where
        ``side`` is above 1."""
        return self._of_truth("board_f32")

    @property
    def object(self) -> NDArray[np.uint32] | None:
        """(h, w): the number of what is seen, 0 for the board, in whose frame ``board`` then is; None where the scene has no objects."""
        self._of_truth("side")
        return self._truth.get("object")

    @cached_property
    def board(self) -> NDArray[np.float64]:
        """(h, w, 2): the same as ``board_f32`` at full precision, each pixel traced for it alone, as in an NPY. It is made when it is first
        asked for."""
        self._of_truth("side")
        return _core.truth(self.scene._handle, *self._accuracy)

    def halves(self) -> tuple[HalfPicture, HalfPicture]:
        """Left and right half, as views: nothing is copied. The middle column of an odd width belongs to neither."""
        width = self.radiance.shape[1]
        columns = {"left": slice(0, width // 2), "right": slice((width + 1) // 2, width)}
        left, right = (HalfPicture(name, self, part) for name, part in columns.items())
        return left, right


@dataclass(frozen=True, eq=False)
class HalfPicture:
    """One half of a picture: views of its arrays."""

    name: str
    """``left`` or ``right``."""
    whole: Rendering
    """The picture."""
    columns: slice
    """Its columns in the picture."""

    @property
    def radiance(self) -> NDArray[np.float32]:
        """(h, w of the half)."""
        return self.whole.radiance[:, self.columns]

    @property
    def side(self) -> NDArray[np.uint8]:
        """(h, w of the half)."""
        return self.whole.side[:, self.columns]

    @property
    def board(self) -> NDArray[np.float64]:
        """(h, w of the half, 2), in mm."""
        return self.whole.board[:, self.columns]


@dataclass(frozen=True, eq=False)
class DesignedPrism:
    """A freeform prism that was designed."""

    figures: Report
    """As ``biprism design --json`` prints them."""
    prism: str
    """The prism as the ``[prism]`` part of a scene, in TOML."""
    scene: Scene
    """The scene with this prism in place of its own."""


@dataclass(frozen=True, eq=False)
class RectifiedPair:
    """Maps for ``cv2.remap`` that make two parallel pinholes of the halves: ``cv2.remap(picture, left_x, left_y, cv2.INTER_CUBIC)`` is
    the left image. Pixel centres are at whole numbers there; -1 stands where the half sees nothing."""

    left_x: NDArray[np.float32]
    """(h, w of a half): columns of the picture, in px."""
    left_y: NDArray[np.float32]
    """(h, w of a half): rows of the picture, in px."""
    right_x: NDArray[np.float32]
    """As ``left_x``, of the right half."""
    right_y: NDArray[np.float32]
    """As ``left_y``, of the right half."""
    report: Report
    """Baseline, focal lengths, centres, and what the maps leave at other depths, as ``biprism rectify --json`` prints them."""
    stereo_yml: str
    """The pair for ``cv2.FileStorage``: ``M1 D1 M2 D2 R T P1 P2 Q``."""
