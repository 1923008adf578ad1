"""Settings of the reduction of a plate: training materials and tolerance."""

from dataclasses import dataclass

import numpy as np

from analysis.material import MaterialBox


@dataclass(frozen=True)
class BasisTraining:
    """Settings of a reduced model.

    Attributes
    ----------
    tolerance : float
        Error allowed, relative to a transfer's rms over the band.
    modulus_ratio, poisson_step : float
        Largest gaps between training materials along E (a ratio, of every other one) and nu.
    lines : int
        Number of frequencies at which responses are compared and decomposed.
    rounds : int
        Largest number of rounds, in each of which the error is measured and missing responses are added to the
        vectors.
    """

    tolerance: float = 1e-4
    modulus_ratio: float = 5.0
    poisson_step: float = 0.2
    lines: int = 200
    rounds: int = 3

    def materials(self, box: MaterialBox) -> tuple[list[tuple[float, float]], list[tuple[float, float]]]:
        """(E, nu) that cover the box: those of Krylov spaces, and those at which their modes are corrected.

        The first are the softest, which has most modes, at every nu of a grid. A stiffer plate moves nearly as a
        soft one does at a lower frequency. The second are the softest between two nu and, at ever larger E, by
        turns those between and those of the grid.
        """
        (e0, e1), (n0, n1) = box.youngs_modulus, box.poisson_ratio
        steps_e = 2 * int(np.ceil(np.log(e1 / e0) / np.log(self.modulus_ratio) - 1e-6))
        cells_n = int(np.ceil((n1 - n0) / self.poisson_step - 1e-6))
        n = np.linspace(n0, n1, cells_n + 1)
        between = 0.5 * (n[1:] + n[:-1])
        odd = between if cells_n else n
        stiffer = [
            (x, y) for k, x in enumerate(np.geomspace(e0, e1, steps_e + 1)[1:]) for y in (n if k % 2 else odd)
        ]
        soft, corrected = ([(e0, y) for y in values] for values in (n, between))
        return [(float(x), float(y)) for x, y in soft], [(float(x), float(y)) for x, y in corrected + stiffer]
