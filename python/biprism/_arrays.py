"""Arrays that come in: copied to what the compiled part takes, or refused, never misread."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core

Side = Literal["left", "right"]
Transfer = Literal["linear", "srgb"]
Records = NDArray[np.void]

CORNER = np.dtype(
    [
        ("view", "u1"),
        ("index", "<i4", (2,)),
        ("position_px", "<f8", (2,)),
        ("covariance_px2", "<f8", (2, 2)),
        ("contrast", "<f8"),
        ("residual", "<f8"),
        ("polarity", "u1"),
    ]
)
"""A corner: ``view`` 0 left, 1 right, 2 whole picture; ``index`` column and row; ``position_px`` (x, y) in px of the whole picture, the
centre of pixel (i, j) at (i + 0.5, j + 0.5); ``covariance_px2`` of it, in px^2; ``contrast`` bright less dark and ``residual`` (root mean
square of picture less model) in the unit of the picture; ``polarity`` 0 where the diagonal from the upper left is bright, 1 the other.
Of corners of a file that does not tell: NaN, and 2."""

VIEWS = ("left", "right", "whole")
_LARGEST = {1: 255.0, 2: 65535.0}


def plain(values: ArrayLike, what: str) -> NDArray[Any]:
    """The array of ``values``, which are real numbers and not masked."""
    if isinstance(values, np.ma.MaskedArray) and np.ma.is_masked(values):
        raise TypeError(f"{what}: some values are masked, and a mask would be lost: fill them")
    array = np.asarray(values)
    if array.dtype.kind not in "iuf":
        raise TypeError(f"{what}: the values are of type {array.dtype}, and must be real numbers")
    return array


def finite(array: NDArray[Any], what: str) -> None:
    """Refuses what is no number."""
    if not np.isfinite(array).all():
        raise ValueError(f"{what}: a value is not finite")


def picture(image: ArrayLike, transfer: Transfer | None) -> NDArray[np.float32]:
    """Linear light, (h, w) float32 in rows, of an image of floats or of stored values of 8 or 16 bits."""
    array = plain(image, "the picture")
    if array.ndim != 2 or 0 in array.shape:
        raise ValueError(f"the picture: its shape is {array.shape}, and must be (h, w); make luminance of colours first")
    if array.dtype.kind == "f":
        if transfer in (None, "linear"):
            with np.errstate(over="ignore"):
                light = np.ascontiguousarray(array, dtype=np.float32)
            finite(light, "the picture")
            return light
        finite(array, "the picture")
        return _core.light(np.ascontiguousarray(array, dtype=np.float64), str(transfer))
    if array.dtype.kind != "u" or array.dtype.itemsize not in _LARGEST:
        raise TypeError(f"the picture: the values are of type {array.dtype}, and must be floats, uint8 or uint16")
    if transfer is None:
        raise TypeError(
            f"the picture: values of {array.dtype} do not say how they became of light: give transfer='linear' for most machine "
            "cameras, transfer='srgb' for a phone's or a photo camera's"
        )
    stored = np.ascontiguousarray(array, dtype=np.float64) / _LARGEST[array.dtype.itemsize]
    return _core.light(stored, transfer)


def pairs(values: ArrayLike, what: str) -> tuple[NDArray[np.float64], tuple[int, ...]]:
    """Positions as (n, 2) float64, and the shape of the answers: that of the values without their last axis."""
    array = plain(values, what)
    if array.ndim == 0 or array.shape[-1] != 2:
        raise ValueError(f"{what}: the shape is {array.shape}, and must be (2,), (n, 2) or (.., 2)")
    finite(array, what)
    return np.ascontiguousarray(array, dtype=np.float64).reshape(-1, 2), array.shape[:-1]


def sides(side: Side | Sequence[str] | NDArray[Any], shape: tuple[int, ...]) -> NDArray[np.uint8]:
    """The numbers of sides, one for each answer of this shape."""
    names = np.broadcast_to(np.asarray(side), shape).ravel()
    known = {"left": 0, "right": 1}
    if any(str(name) not in known for name in names):
        raise ValueError("a side is neither 'left' nor 'right'")
    return np.array([known[str(name)] for name in names], dtype=np.uint8)


def records(found: tuple[NDArray[np.uint8], list[tuple[str, str, int]]], shape: tuple[int, ...]) -> Records:
    """The structured array of records that came as bytes."""
    data, fields = found
    dtype = np.dtype([(name, kind) if n == 1 else (name, kind, (n,)) for name, kind, n in fields])
    return data.view(dtype).reshape(shape)


def given_corners(corners: NDArray[Any]) -> dict[str, NDArray[Any]]:
    """The fields of corners as the compiled part takes them; what a record does not say of itself is NaN."""
    names = corners.dtype.names or ()
    missing = [name for name in ("view", "index", "position_px") if name not in names]
    if missing or corners.ndim != 1:
        raise TypeError(f"the corners: they must be records of biprism.CORNER, (n,); {missing or corners.shape} is amiss")
    n = len(corners)
    unknown = {"covariance_px2": np.full((n, 2, 2), np.nan), "polarity": np.full(n, 2)}
    kinds = {"view": np.uint8, "index": np.int32, "position_px": np.float64, "covariance_px2": np.float64, "polarity": np.uint8}
    fields: dict[str, NDArray[Any]] = {}
    for name, kind in kinds.items():
        values = corners[name] if name in names else unknown[name]
        taken = np.ascontiguousarray(plain(values, f"the corners' {name}"), dtype=kind)
        if np.issubdtype(kind, np.integer) and not np.array_equal(taken, values):
            raise ValueError(f"the corners' {name}: a value does not fit into {np.dtype(kind)}")
        fields[name] = taken
    finite(fields["position_px"], "the corners' position_px")
    return fields
