"""How finely a plate is discretised."""

from dataclasses import dataclass, field

from analysis.material import MaterialBox
from simulation.meshing.recipe import MeshRecipe

USUAL_LOSS = 0.025
"""Loss factor at which tolerances hold: the middle of a thermoplastic's range."""
LEAST_SHARE = 0.02
"""Of a tolerance that any material leaves."""


@dataclass(frozen=True)
class Fineness:
    """Mesh, degree of the functions on it, and which of them are kept.

    Attributes
    ----------
    mesh : MeshRecipe
    degree : int
        Of the functions among which those kept are chosen.
    tolerance : float
        Share of an answer's energy for which a function is kept; 0 keeps all. With 3e-9 transfers between patches
        are good to 0.01 to 0.03 % of their rms, with 1e-8 to 0.1 %. See `share`.
    """

    mesh: MeshRecipe = field(default_factory=MeshRecipe)
    degree: int = 7
    tolerance: float = 3e-9

    def __post_init__(self) -> None:
        if not 2 <= self.degree <= 12:
            raise ValueError(f"degree is {self.degree}; allowed 2 to 12")
        if not 0.0 <= self.tolerance <= 1e-2:
            raise ValueError(f"tolerance of functions is {self.tolerance:g}; allowed 0 to 0.01")

    def share(self, box: MaterialBox) -> float:
        """Share of an answer's energy for which a function is kept: smaller for materials with little damping.

        Functions left out shift resonances, by 1e-5 with 3e-9, and a transfer errs by the shift over the width of
        a resonance: of sheet metals that is a tenth of a thermoplastic's.
        """
        low, high = box.loss_factor
        usual = float((low * high) ** 0.5)
        return self.tolerance * min(1.0, max(usual / USUAL_LOSS, LEAST_SHARE))
