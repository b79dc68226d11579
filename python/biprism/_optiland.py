"""A half of a prism in Optiland."""

from __future__ import annotations

from typing import Any

from ._arrays import Side
from ._scene import Scene


def to_optiland(scene: Scene, side: Side = "right") -> Any:
    """A half of the scene's prism as an ``optiland.optic.Optic``: the pinhole as its only object point, front, back, and the board's
    plane as the image, whose x and y are those of the board, in mm; all in the frame of the prism. The glass has the index that
    the scene states at its ``prism.wavelength_nm``: rays of both programs agree to 1e-6 mm on the board, those of a scene with dispersion in
    light of that wavelength (``scene.trace(px, wavelength_nm=...)``).

    Raises ImportError without Optiland (``pip install optiland``), SceneError for surfaces that are no polynomials, and for
    ``[effect.manufacture]``, which a lens file does not have.
    """
    from optiland.optic.optic import Optic

    return Optic.from_dict(scene.optiland_file(side))
