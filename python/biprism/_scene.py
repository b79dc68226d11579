"""A scene: camera, prism, board and effects."""

from __future__ import annotations

import json
import math
import os
import warnings
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from ._arrays import CORNER, Records, Side, Transfer, given_corners, pairs, picture, records, sides
from ._errors import SceneError
from ._results import Accuracy, DesignedPrism, RectifiedPair, Rendering, Report

Level = Literal["draft", "standard", "exact", "reference"]
_LEVELS = ("draft", "standard", "exact", "reference")


class Scene:
    """A scene, which never changes: ``replace`` makes another one.

    It is equal to one of the same values, and pickles as its text, with the folder from which the files that it names are found.
    """

    __slots__ = ("_handle",)
    _handle: _core.SceneHandle
    __hash__ = None  # type: ignore[assignment]

    def __init__(self, source: str | Mapping[str, Any], *, folder: str | os.PathLike[str] | None = None) -> None:
        """A scene of a TOML text, or of values: the tables of a scene file as dicts, in the units of their keys.

        Files that it names are looked for in ``folder``, or where the process is now.

        Raises SceneError for the first fault.
        """
        place = Path(os.curdir if folder is None else folder).resolve()
        if isinstance(source, str):
            self._handle = _core.SceneHandle.of_text(source, "scene", place)
        elif isinstance(source, Mapping):
            self._handle = _core.SceneHandle.of_values(_json(source, "scene"), "scene", place)
        else:
            raise TypeError(f"a scene is a text or a dict, not {type(source).__name__}; Scene.load reads a file")

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Scene:
        """The scene of a file.

        Raises SceneError where it cannot be read, and for the first fault in it, with line and column.
        """
        text = _core.file_text(path)
        return cls._of(_core.SceneHandle.of_text(text, os.fspath(path), Path(path).resolve().parent))

    @classmethod
    def _of(cls, core: _core.SceneHandle) -> Scene:
        scene = cls.__new__(cls)
        scene._handle = core
        return scene

    def replace(self, values: Mapping[str, Any]) -> Scene:
        """The scene with other values, by their keys: ``scene.replace({"prism.index": 1.5, "board.position_mm[2]": 800})``. None takes a
        key out, so that its default holds.

        Raises SceneError, whose ``key`` is the key at fault.
        """
        if not isinstance(values, Mapping):
            raise TypeError(f"values are a dict by their keys, not {type(values).__name__}")
        for key, value in values.items():
            _json({key: value}, self._handle.place, key)
        return self._of(self._handle.with_values(_json(values, self._handle.place)))

    @property
    def text(self) -> str:
        """Its TOML text; with comments as long as nothing was replaced."""
        return self._handle.text

    @property
    def values(self) -> dict[str, Any]:
        """The values that the text states, as tables."""
        values: dict[str, Any] = json.loads(self._handle.values_json())
        return values

    @property
    def folder(self) -> str | None:
        """Where the files that it names are looked for."""
        return self._handle.folder

    @property
    def name(self) -> str:
        """Its name."""
        return self._handle.name

    @property
    def prism(self) -> str:
        """The kind of its prism."""
        return self._handle.prism

    @property
    def size_px(self) -> tuple[int, int]:
        """Columns and rows of its picture."""
        return self._handle.size_px

    def __repr__(self) -> str:
        width, height = self.size_px
        return f"<biprism.Scene {self.name!r}: {self.prism} prism, {width} x {height} px, from {self._handle.place!r}>"

    def __eq__(self, other: object) -> bool:
        return self._handle.equals(other._handle) if isinstance(other, Scene) else NotImplemented

    def __reduce__(self) -> tuple[Any, ...]:
        return _restored, (self.text, self._handle.place, self.folder)

    def render(self, accuracy: Level | float | None = None, *, truth: bool = True) -> Rendering:
        """The picture: what ``biprism render`` writes, bit by bit.

        ``accuracy`` is a level, or how far an edge or corner may lie from its true place, in px; without it the scene's own holds.
        ``truth=False`` leaves out what the pixels see.

        Warns where it does not keep what was asked for, as ``account["unmet"]`` tells.

        Raises SceneError where the instrument cannot be built.
        """
        asked = _accuracy(accuracy)
        planes = _core.render(self._handle, *asked, truth)
        seen: dict[str, NDArray[Any]] = {k: v for k, v in planes.items() if k in ("side", "board_f32", "object")}
        account: Report = json.loads(planes["account"])
        for words in account["unmet"]:
            warnings.warn(words, stacklevel=2)
        return Rendering(self, planes["radiance"], account, planes.get("colour"), planes.get("noise"), asked, seen)

    def corners(self, image: ArrayLike | Rendering, *, transfer: Transfer | None = None) -> Records:
        """The corners of its board in both halves of a picture of it: records of ``biprism.CORNER``, (n,), whose ``index`` is the column
        and row of the board. ``image`` is as in ``biprism.corners``.

        Warns, and leaves a half out, where the scene does not tell which corners of the board were found there.

        Raises SceneError for a picture of another size, and a board without a checkerboard.
        """
        data, told = _core.corners_on_board(self._handle, _light(image, transfer))
        for view in json.loads(told):
            if lost := view["rejected"].get("not-indexed"):
                warnings.warn(
                    f"{view['view']}: the scene does not tell which corners of the board the {lost} that were found are: its board must "
                    "be where the picture's is, to 0.3 of a square",
                    stacklevel=2,
                )
        return data.view(CORNER)

    def measure(
        self,
        image: ArrayLike | Rendering | Records,
        *,
        own: bool = False,
        budget: bool = False,
        transfer: Transfer | None = None,
    ) -> Report:
        """The report of a picture of its instrument, or of corners (records of ``biprism.CORNER``): how far the pair is from two ideal
        pinhole cameras, as ``biprism measure --json`` prints it.

        ``own``: the picture was rendered from this very scene, so that exact corners stand beside the measured ones; with ``budget``, also
        where the error of each corner comes from. Without ``own`` the board's pose is fitted to the picture.

        Raises SceneError for a picture of another size, corners outside their half, and a scene without prism or checkerboard.
        """
        if budget and not own:
            raise ValueError("a budget needs the exact corners: give own=True")
        if own and isinstance(image, Rendering) and image.scene != self:
            raise ValueError("the picture was rendered from another scene: measure it by its own one, or without own=True")
        if isinstance(image, np.ndarray) and image.dtype.names is not None:
            return _report(_core.measure(self._handle, None, given_corners(image), own, budget))
        light = _light(image, transfer)
        return _report(_core.measure(self._handle, light, None, own, budget))

    def compare(self, *, budget: bool = False) -> Report:
        """The report of its flat prism against the freeform one, or of the one prism that it gives by its surfaces, each rendered, detected
        and measured, as ``biprism compare --json`` prints it, without times.

        Raises SceneError where a prism cannot be designed or built.
        """
        return _report(_core.compare([self._handle], budget))

    def trace(self, px: ArrayLike, *, wavelength_nm: float | None = None) -> Records:
        """Where pixel positions lead: ``px`` is (.., 2), the centre of pixel ``[j, i]`` at (i + 0.5, j + 0.5). In light of
        ``wavelength_nm`` in vacuum, whatever light the scene has; that needs ``prism.glass``.

        Records of shape (..), of f64 in mm, NaN where there is nothing: ``pixel_px`` (2), ``board_mm`` (2) on the board, ``world_mm`` (3),
        ``front_mm`` and ``back_mm`` (3) on the prism, ``inner_direction`` and ``exit_direction`` (3); ``side`` 0 left, 1 right, 2 not known;
        ``class`` as ``Rendering.side``.

        Raises SceneError where the instrument cannot be built, and of a wavelength of which the scene's glass says nothing.
        """
        points, shape = pairs(px, "px")
        return records(_core.trace(self._handle, points, _wavelength(wavelength_nm)), shape)

    def aim(
        self, side: Side | Sequence[str] | NDArray[Any], board_mm: ArrayLike, *, wavelength_nm: float | None = None
    ) -> Records:
        """Which pixel positions see points of the board through a side of the prism: ``board_mm`` is (.., 2), ``side`` one for all or each,
        ``wavelength_nm`` as for ``trace``.

        Records of shape (..): ``board_mm`` (2), ``pixel_px`` (2) or NaN, ``side``, ``class`` as ``Rendering.side``, and ``seen`` 1 where
        the position is on the sensor and looks through that side.

        Raises SceneError as ``trace`` does.
        """
        points, shape = pairs(board_mm, "board_mm")
        return records(_core.aim(self._handle, sides(side, shape), points, _wavelength(wavelength_nm)), shape)

    def design(self, **options: Any) -> DesignedPrism:
        """The freeform prism that is designed from its camera and flat prism; options are those of ``biprism design``, as
        ``objective="toed-in", degree=7``.

        Raises SceneError where none can be designed, and of options that are none.
        """
        figures, prism, values = _core.design(self._handle, _verb("design", options))
        # The prism comes in its own frame, and stays where the scene has it.
        place = {key: value for key, value in self.values["prism"].items() if key in ("position_mm", "tilt_deg")}
        scene = self.replace({"prism": {**json.loads(values), **place}})
        return DesignedPrism(json.loads(figures), prism, scene)

    def rectify(self, depth_mm: float | None = None, *, residuals_at_mm: Iterable[float] = ()) -> RectifiedPair:
        """Maps that make a rectified pair of a picture's halves, right ``depth_mm`` from the camera, or at the board; the report says what
        they leave there and at the depths of ``residuals_at_mm``.

        Raises SceneError without a prism, and where the halves see nothing in common.
        """
        depths = [_depth(depth) for depth in residuals_at_mm]
        return RectifiedPair(**_rectified(_core.rectify(self._handle, None if depth_mm is None else _depth(depth_mm), depths)))

    def analyse(self, name: str, **options: Any) -> Report:
        """The figures of a study: ``spot``, ``field-curvature``, ``mtf``, ``reprojection``, ``surface`` or ``stereo``; options are those of
        ``biprism analyse``, as ``depth_mm=[800, 1200], grid=17``. Tables by their names, each a list of rows.

        Raises SceneError for a study that is none, and what it says of the scene.
        """
        return _report(_core.figures(self._handle, _verb(f"analyse {name}", options)))

    def optiland_file(self, side: Side) -> Report:
        """A half of its prism, with camera and board, as a lens file of Optiland, in the frame of the prism: see ``biprism.to_optiland``.

        Raises SceneError for surfaces that are no polynomials.
        """
        return _report(_core.optiland(self._handle, int(sides(side, ())[0])))


def compare(scenes: Iterable[Scene], *, budget: bool = False) -> Report:
    """The report of the prisms of several scenes, at most 8, each as its scene gives it; of one scene that of ``Scene.compare``.

    Raises SceneError where there are too many, and where a prism cannot be designed or built.
    """
    handles = [scene._handle for scene in scenes]
    if not handles:
        raise ValueError("there is no scene to compare")
    return _report(_core.compare(handles, budget))


def _restored(text: str, place: str, folder: str | None) -> Scene:
    return Scene._of(_core.SceneHandle.of_text(text, place, folder))


def _report(text: str) -> Report:
    report: Report = json.loads(text)
    return report


def _rectified(planes: dict[str, Any]) -> dict[str, Any]:
    return {"report": json.loads(planes.pop("report")), "stereo_yml": planes.pop("stereo"), **planes}


def _light(image: ArrayLike | Rendering, transfer: Transfer | None) -> NDArray[np.float32]:
    return picture(image.radiance if isinstance(image, Rendering) else image, transfer)


def _accuracy(accuracy: Level | float | None) -> Accuracy:
    """The level, or the target in px."""
    if accuracy is None:
        return None, None
    if isinstance(accuracy, str):
        if accuracy not in _LEVELS:
            raise ValueError(f"accuracy is {accuracy!r}, and must be a level ({', '.join(_LEVELS)}) or a target in px")
        return accuracy, None
    target = float(accuracy)
    if not 0.0 < target <= 1.0:
        raise ValueError(f"accuracy is {accuracy!r}, and a target must be above 0 and at most 1 px")
    return None, target


def _depth(depth_mm: float) -> float:
    depth = float(depth_mm)
    if not (math.isfinite(depth) and depth > 0.0):
        raise ValueError(f"a depth is {depth_mm!r}, and must be above 0 mm and finite")
    return depth


def _wavelength(wavelength_nm: float | None) -> float | None:
    return None if wavelength_nm is None else float(wavelength_nm)


def _json(values: Mapping[str, Any], place: str, key: str | None = None) -> str:
    """Values as JSON, those of NumPy as Python's own."""

    def own(value: Any) -> Any:
        if isinstance(value, (np.generic, np.ndarray)):
            return value.tolist()
        if isinstance(value, Mapping):
            return dict(value)
        if isinstance(value, os.PathLike):
            return os.fspath(value)
        raise TypeError(f"a scene holds numbers, words, lists and tables, not {type(value).__name__}")

    try:
        return json.dumps(dict(values), default=own, allow_nan=False)
    except ValueError as error:
        raise SceneError(place, None, None, key, f"a value is not finite, or holds itself ({error})", "give numbers") from None


def _verb(verb: str, options: Mapping[str, Any]) -> str:
    """A verb with its options, as a batch takes it."""
    words = [verb]
    for key, value in options.items():
        option = "--" + key.replace("_", "-")
        for one in value if isinstance(value, (list, tuple, np.ndarray)) else [value]:
            if one is None or one is False:
                continue
            word = option if one is True else f"{option}={one.item() if isinstance(one, np.generic) else one}"
            words.append(word)
    if any(" " in word for word in words[1:]) or len(verb.split()) > 2:
        raise ValueError(f"{' '.join(words)!r}: no word of it may hold a blank")
    return " ".join(words)
