"""Principal FRFs: a few sums of many FRFs that share their poles, on which the poles are searched.

A sum of FRFs with real factors has the same poles; with as many sums as there are directions in which the FRFs
differ beyond their errors, nothing about the poles is lost. The directions are the left singular vectors of the
matrix of all FRFs (as in the complex mode indicator function: Shih, Tsuei, Allemang and Brown, Mech. Syst. Signal
Process. 2, 1988). A search on them takes the time of a few FRFs. It also finds more: every pole costs one residue
per FRF, so BIC on two hundred FRFs of a roving hammer, between which peaks move by a line, gives up modes that
thirty of the same FRFs show.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analysis.identification.measured import Measured
from analysis.identification.modes import Modes
from analysis.identification.running_median import running_median

MANY = 32
"""FRFs up to which all of them are searched together."""

PRINCIPAL_FRFS = 16
"""Principal FRFs: with 8 to 20 of 222 measured FRFs of an aeroplane model all 13 modes are found; with 24
one is lost whose neighbour is two half widths away."""

RUNNING_MEDIAN_LINES = 9
"""Lines of the running median in which the size of all FRFs at a line is told: no line of hum counts."""


@dataclass(frozen=True)
class PrincipalFrfs:
    """Sums of FRFs.

    Attributes
    ----------
    factors : (P, K) ndarray
        Of every FRF in every sum.
    measured : Measured
        The P sums.
    """

    factors: NDArray[np.float64]
    measured: Measured

    def modes(self, modes: Modes) -> Modes:
        """Return modes of the FRFs, as those of the sums."""
        return replace(
            modes, residues=self.factors @ modes.residues, coefficients=self.factors @ modes.coefficients
        )


def principal_frfs(measured: Measured) -> PrincipalFrfs:
    """Form the principal FRFs of many FRFs.

    Every FRF counts alike, whatever its level, and so does every line, so that small modes are in the sums, too.
    Variances are not taken over: those of coherences say nothing of peaks that move from one FRF to the next,
    and a fit to the sums finds its noise in its residual.

    Parameters
    ----------
    measured : Measured
        K FRFs on F lines, none of them zero.
    """
    level = np.sqrt((np.abs(measured.h) ** 2).mean(axis=1, keepdims=True))
    scaled = measured.h / level
    size = running_median((np.abs(scaled) ** 2).mean(axis=0)[None], RUNNING_MEDIAN_LINES, "nearest")[0]
    even = scaled / np.sqrt(np.maximum(size, np.finfo(float).tiny))
    parts = np.concatenate([even.real, even.imag], axis=1)
    directions = np.linalg.eigh(parts @ parts.T)[1][:, ::-1][:, :PRINCIPAL_FRFS]
    factors = np.ascontiguousarray((directions / level).T)
    return PrincipalFrfs(factors, replace(measured, h=factors @ measured.h, variance=None))
