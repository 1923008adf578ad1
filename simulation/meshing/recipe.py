"""Sizes of the mesh, in multiples of the plate's thickness."""

from dataclasses import dataclass
from typing import Self

PER_WAVE = 0.55
"""Largest edge of a cell in bending wavelengths, for functions of degree 7. Functions of higher degree then have a
few 1e-6 of a response's energy; with 0.65, 4e-5 on a disc, and with 0.9, 2e-4 to 3e-3."""
MOST_CELLS_ACROSS = 25
"""Cells across a large plate that are enough where the waves are long: a sheet of 2 m2, 1 mm thick, would have
8300 triangles of the usual size and a million functions, for waves of 0.2 m."""


@dataclass(frozen=True)
class MeshRecipe:
    """Sizes of the mesh.

    Strips of quadrilaterals along every border resolve the shear layer of a Reissner-Mindlin plate, whose width is
    of the order of the thickness h; so their width is given in h.

    Attributes
    ----------
    spacing : float
        Largest edge of a cell of a plate 3 mm thick, m; for other plates it scales with the root of the thickness,
        like bending wavelengths. See `of_plate`.
    strip : float
        Width of the strips on both sides of the borders of patches and zones, in h.
    edge_strip : float
        Width of the strips along free and supported edges, in h.
    growth : float
        Growth of cells with the distance from a border.
    turn : float
        Largest turn of a border within a cell, rad.
    grading : float
        Share of a cell at a corner taken by its smallest part; 0: no refinement of corners.
    levels : int
        How many times cells next to a corner are refined.
    outer_corners : bool
        Whether corners of the outline are refined, too; else only those of patches and re-entrant ones.
    pieces : int
        Smallest number of cells along a side of a patch, including those at its corners.
    """

    spacing: float = 0.040
    strip: float = 0.83
    edge_strip: float = 1.0
    growth: float = 1.3
    turn: float = 0.79
    grading: float = 0.3
    levels: int = 1
    outer_corners: bool = False
    pieces: int = 3

    def __post_init__(self) -> None:
        for name, low, high in (
            ("spacing", 1e-3, 10.0),
            ("strip", 0.05, 20.0),
            ("edge_strip", 0.05, 20.0),
            ("growth", 0.1, 2.0),
            ("turn", 0.05, 1.6),
            ("grading", 0.0, 0.6),
            ("levels", 0, 20),
            ("pieces", 1, 50),
        ):
            value = getattr(self, name)
            if not low <= value <= high:
                raise ValueError(f"mesh recipe: {name} is {value:g}; allowed {low:g} to {high:g}")

    @classmethod
    def of_plate(cls, area: float, thickness: float, wavelength: float) -> Self:
        """Return the usual recipe, with larger cells on large plates, at most `PER_WAVE` wavelengths.

        Parameters
        ----------
        area : float
            Of the plate, m2.
        thickness : float
            m.
        wavelength : float
            The shortest of bending waves, m.

        Returns
        -------
        MeshRecipe
        """
        unit = float((thickness / 0.003) ** 0.5)
        return cls(
            spacing=min(max(cls.spacing, area**0.5 / MOST_CELLS_ACROSS / unit), PER_WAVE * wavelength / unit)
        )

    def bulk(self, thickness: float) -> float:
        """Largest edge of a cell, m."""
        return self.spacing * float((thickness / 0.003) ** 0.5)
