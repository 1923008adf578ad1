"""How a plate is reduced: for which materials, and how exactly."""

from dataclasses import dataclass

import numpy as np

from analysis.material import MaterialBox


@dataclass(frozen=True)
class BasisTraining:
    """How a reduced model is made.

    Attributes
    ----------
    tolerance : float
        Error allowed, relative to a transfer's rms over the band.
    modulus_ratio, poisson_step : float
        Widest gaps between trained materials.
    lines : int
        Frequencies at which responses are compared and decomposed.
    rounds : int
        How often the error is measured, and what was missed joins the vectors, before the reduction is given up.
    """

    tolerance: float = 1e-4
    modulus_ratio: float = 5.0
    poisson_step: float = 0.2
    lines: int = 200
    rounds: int = 3

    def materials(self, box: MaterialBox) -> list[tuple[float, float]]:
        """(E, nu) of a grid that covers the box, and of the middle of every cell."""
        (e0, e1), (n0, n1) = box.youngs_modulus, box.poisson_ratio
        cells_e = int(np.ceil(np.log(e1 / e0) / np.log(self.modulus_ratio) - 1e-6))
        cells_n = int(np.ceil((n1 - n0) / self.poisson_step - 1e-6))
        e, n = np.geomspace(e0, e1, cells_e + 1), np.linspace(n0, n1, cells_n + 1)
        grid = [(x, y) for x in e for y in n]
        centers = [(x, y) for x in np.sqrt(e[1:] * e[:-1]) for y in 0.5 * (n[1:] + n[:-1])]
        return [(float(x), float(y)) for x, y in grid + centers]
