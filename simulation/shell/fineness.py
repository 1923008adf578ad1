"""Settings of the discretisation of a plate."""

from dataclasses import dataclass

from analysis.experiment import Plate
from analysis.material import MaterialBox
from simulation.meshing.recipe import MeshRecipe
from simulation.shell.shortest_wave import shortest_wave

USUAL_LOSS = 0.025
"""Loss factor for which tolerances are stated: the middle of a thermoplastic's range."""
LEAST_TOLERANCE_FACTOR = 1e-3
"""Smallest factor on a tolerance, for any material."""


@dataclass(frozen=True)
class Fineness:
    """Mesh, degree of its functions, and tolerance of their selection.

    Attributes
    ----------
    mesh : MeshRecipe, optional
        Unless given, the usual one with cells small enough for the shortest wave, see `recipe`.
    degree : int
        Degree of the functions before the selection.
    tolerance : float
        Share of a response's energy from which a function is kept; 0 keeps all. With 3e-9 the error of transfers
        between patches is 0.01 to 0.03 % of their rms, with 1e-8 0.1 %. See `share`.
    """

    mesh: MeshRecipe | None = None
    degree: int = 7
    tolerance: float = 3e-9

    def __post_init__(self) -> None:
        if not 2 <= self.degree <= 12:
            raise ValueError(f"degree is {self.degree}; allowed 2 to 12")
        if not 0.0 <= self.tolerance <= 1e-2:
            raise ValueError(f"tolerance of functions is {self.tolerance:g}; allowed 0 to 0.01")

    def recipe(self, plate: Plate, box: MaterialBox, band: tuple[float, float]) -> MeshRecipe:
        """Return the sizes of a plate's mesh.

        Parameters
        ----------
        band : (float, float)
            Hz.
        """
        return self.mesh or MeshRecipe.of_plate(plate.area, plate.thickness, shortest_wave(plate, box, band))

    def share(self, box: MaterialBox) -> float:
        """Share of a response's energy from which a function is kept: smaller for materials with little damping.

        Functions left out shift resonances. The error of a transfer is this shift over the width of a resonance,
        and plates with few, sharp resonances need more functions for the same shift: the share goes with the
        square of the loss factor. A plate of aluminium with two patches, loss factor 0.2 %, has an error of 0.5 %
        of the rms with a share in proportion to the loss factor, and of 0.05 % with its square.
        """
        return self.tolerance * min(1.0, max(relative_loss(box) ** 2, LEAST_TOLERANCE_FACTOR))


def relative_loss(box: MaterialBox) -> float:
    """Middle of a material's loss factors, over that for which tolerances are stated."""
    low, high = box.loss_factor
    return float((low * high) ** 0.5) / USUAL_LOSS
