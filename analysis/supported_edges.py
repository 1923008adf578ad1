"""What a plate's supports hold along its edges, and whether each finds its place."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from analysis.geometry.fault import GeometryError
from analysis.geometry.loop import Loop
from analysis.plate_parts import check_disc
from analysis.support import Piece, Support

Pieces = Callable[[Support], tuple[Piece, ...]]
"""Parts of a plate's edge that a support along it holds; see `Support.pieces`."""

NEAR_THE_EDGE = "move it, choose a smaller radius, or hold a part of the edge with from and to"


@dataclass(frozen=True)
class SupportedEdge:
    """Where one support holds.

    Attributes
    ----------
    support : Support
    loop : int
        0 for the outline, n for the n-th hole.
    pieces : tuple of (int, float, float)
        Curves of that loop, from 0, with the first and last parameter of the part held.
    """

    support: Support
    loop: int
    pieces: tuple[Piece, ...]


def supported_edges(supports: Sequence[Support], pieces: Pieces) -> list[SupportedEdge]:
    """Return what supports hold along the edges; where two meet, the later one counts."""
    found: list[SupportedEdge] = []
    for support in supports:
        if support.at_point:
            continue
        number, held = support.hole or 0, pieces(support)
        found = [replace(one, pieces=_without(one.pieces, held)) if one.loop == number else one for one in found]
        found.append(SupportedEdge(support, number, held))
    return [one for one in found if one.pieces and one.support.kind != "free"]


def check_supports(supports: Sequence[Support], outline: Loop, holes: Sequence[Loop], pieces: Pieces) -> None:
    """Check that every support finds its place on a plate.

    Parameters
    ----------
    pieces : callable
        Parts of the edge that a support holds.

    Raises
    ------
    ValueError
        For a hole or an edge that the plate does not have; `GeometryError`, with the place, for a disc that does
        not lie on the plate and ends off the edge.
    """
    for number, support in enumerate(supports):
        if support.hole is not None and support.hole > len(holes):
            raise ValueError(f"support[{number}]: hole {support.hole} does not exist; the plate has {len(holes)}")
        if support.point is not None:
            check_disc(f"support[{number}]", support.point, support.radius, outline, holes, NEAR_THE_EDGE)
            continue
        try:
            pieces(support)
        except GeometryError as error:
            raise GeometryError(f"support[{number}]: {error}", *error.places) from error
        except ValueError as error:
            raise ValueError(f"support[{number}]: {error}") from error


def _without(pieces: tuple[Piece, ...], taken: tuple[Piece, ...]) -> tuple[Piece, ...]:
    """Return `pieces` less what `taken` covers of them."""
    left = list(pieces)
    for curve, first, last in taken:
        cut: list[Piece] = []
        for number, low, high in left:
            if number != curve or last <= low or first >= high:
                cut.append((number, low, high))
                continue
            cut += [(number, a, b) for a, b in ((low, first), (last, high)) if b > a]
        left = cut
    return tuple(left)
