"""How finely a plate is discretised."""

from dataclasses import dataclass, field

from simulation.meshing.recipe import MeshRecipe


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
        are good to 0.01 to 0.03 % of their rms, with 1e-8 to 0.1 %.
    """

    mesh: MeshRecipe = field(default_factory=MeshRecipe)
    degree: int = 7
    tolerance: float = 3e-9

    def __post_init__(self) -> None:
        if not 2 <= self.degree <= 12:
            raise ValueError(f"degree is {self.degree}; allowed 2 to 12")
        if not 0.0 <= self.tolerance <= 1e-2:
            raise ValueError(f"tolerance of functions is {self.tolerance:g}; allowed 0 to 0.01")
