"""A declaration whose geometry cannot be, and where: what a picture of it is drawn from."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pydantic_core import ErrorDetails

    from analysis.geometry.curves import Curve, Point


@dataclass(frozen=True)
class Misplaced:
    """What was declared, and where it is wrong.

    Attributes
    ----------
    source : Path
        The file.
    declared : mapping
        What stands in it, unchecked.
    places : tuple of (float, float)
        Where it is wrong, m.
    loose : tuple of Curve
        Curves of a drawing that close to no outline.
    """

    source: Path
    declared: Mapping[str, Any]
    places: "tuple[Point, ...]"
    loose: "tuple[Curve, ...]" = ()


def misplaced(source: Path, declared: Mapping[str, Any], details: "Sequence[ErrorDetails]") -> Misplaced | None:
    """Gather the places that pydantic's errors name.

    Parameters
    ----------
    source : Path
        File of the declaration.
    declared : mapping
        Its keys and values.

    Returns
    -------
    Misplaced or None
        None where no geometry is wrong.
    """
    from analysis.geometry.fault import GeometryError  # --help waits for no library

    errors = [detail.get("ctx", {}).get("error") for detail in details]
    places = [place for error in errors if isinstance(error, GeometryError) for place in error.places]
    return Misplaced(source, declared, tuple(places)) if places else None
