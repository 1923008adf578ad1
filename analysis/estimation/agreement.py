"""Whether runs that are averaged as one measured one and the same FRF.

With one H for all runs, and with an H of its own for each, the drives explain of the responses' energy

    E_1 = sum_f G_yu G_uu^-1 G_uy,    E_n = sum_f sum_i w_i G_yu,i G_uu,i^-1 G_uy,i,

where G = sum_i w_i G_i. Of FRFs that have nothing to do with each other, E_1 keeps on average what each run
gives by itself, E_0 = sum_f sum_i w_i^2 G_yu,i G_uu^-1 G_uy,i. The agreement (E_1 - E_0) / (E_n - E_0) is
therefore 1 for the same FRF and 0 for unrelated ones. Of two runs of equal drive it
is 2 Re(H_1 H_2*) / (|H_1|^2 + |H_2|^2), summed over lines (compare the coherence, Bendat and Piersol, Random Data,
2010, ch. 9).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.estimation.spectra import Spectra, pooled

LEAST_AGREEMENT = 0.5
"""Runs that agree less are no averages of one FRF: five points of a free beam agree by -0.2, two of them by -0.9
to 0.85, hits at one point by more than 0.9."""
GOOD_AGREEMENT = 0.9
"""Runs that agree less are worth a note."""
NOISY_COHERENCE = 0.5
"""Coherence within the runs below which noise, and not another point, may be why they do not agree."""


@dataclass(frozen=True)
class RunsAgreement:
    """How far runs agree, for each response.

    Attributes
    ----------
    between : (K,) ndarray
        About 0 for unrelated FRFs, 1 for the same.
    within : (K,) ndarray
        Coherence within the runs, weighted by energy; NaN where no run has more averages than drives.
    runs : int
    """

    between: NDArray[np.float64]
    within: NDArray[np.float64]
    runs: int

    @property
    def different(self) -> NDArray[np.intp]:
        """Responses of which the runs measured different FRFs, not one with much noise."""
        noisy = np.nan_to_num(self.within, nan=1.0) < NOISY_COHERENCE
        return np.flatnonzero((self.between < LEAST_AGREEMENT) & ~noisy)

    @property
    def doubtful(self) -> NDArray[np.intp]:
        """Further responses of which they do not agree well."""
        return np.setdiff1d(np.flatnonzero(self.between < GOOD_AGREEMENT), self.different)


def agreement(parts: Sequence[Spectra]) -> RunsAgreement | None:
    """Return how far the runs of one average agree.

    Parameters
    ----------
    parts : sequence of Spectra
        One for each run, of the same lines.

    Returns
    -------
    RunsAgreement or None
        None for a single run, and where a run alone has fewer averages than drives.
    """
    drives = parts[0].g_uu.shape[1]
    if len(parts) < 2 or any(part.averages < drives for part in parts):
        return None
    whole = pooled(list(parts))
    share = [part.averages / whole.averages for part in parts]
    together = _explained(whole, whole.g_uu)
    apart = np.sum([s * _explained(part, part.g_uu) for s, part in zip(share, parts, strict=True)], axis=0)
    chance = np.sum([s**2 * _explained(part, whole.g_uu) for s, part in zip(share, parts, strict=True)], axis=0)
    between = np.divide(together - chance, apart - chance, out=np.ones_like(apart), where=apart > chance)
    several = [part for part in parts if part.averages > drives]
    within = np.full(len(between), np.nan)
    if several:
        weight = np.array([part.averages for part in several])
        answered = np.sum([w * part.g_yy[1:].sum(0) for w, part in zip(weight, several, strict=True)], axis=0)
        explained = np.sum(
            [w * _explained(part, part.g_uu) for w, part in zip(weight, several, strict=True)], axis=0
        )
        within = np.divide(explained, answered, out=np.zeros_like(explained), where=answered > 0.0)
    return RunsAgreement(between, within, len(parts))


def _explained(part: Spectra, drives: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Sum G_yu G^-1 G_uy of each response over all lines but 0 Hz, (K,); G are the spectra `drives`, (F, M, M)."""
    g_uu, g_yu = drives[1:], part.g_yu[1:]
    power = np.einsum("fii->fi", g_uu).real
    size = np.sqrt(np.maximum(power, 1e-12 * power.max(axis=0, initial=0.0)))  # unplayed lines explain nothing
    size = np.where(size > 0.0, size, 1.0)
    normal = g_uu / (size[:, :, None] * size[:, None, :]) + 1e-12 * np.eye(g_uu.shape[1])
    scaled = g_yu / size[:, None, :]
    solved = np.linalg.solve(normal, np.swapaxes(scaled.conj(), 1, 2))
    return np.asarray(np.einsum("fkm,fmk->k", scaled, solved).real)
