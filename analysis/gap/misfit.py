"""Relative misfit of a fit over the measured lines."""

import numpy as np

from analysis.gap.gap_fit import GapFit
from analysis.gap.sweeps import GapSweeps


def relative_misfit(sweeps: GapSweeps, fit: GapFit) -> float:
    """rms|H_data - H_twin| / rms|H_data| over all lines, channels and sweeps that take part.

    The data are the lines themselves, noise between the nodes included: that part comes from its chi2.
    """
    missed = power = 0.0
    for s, sweep in enumerate(sweeps.compressed):
        rows = sweeps.rows[s]
        smooth = sweep.nodes.at_lines(sweep.coefficients)
        away = sweep.nodes.at_lines(sweep.coefficients - fit.predicted[s])
        share = rows.mean(-1)
        here = np.interp(sweep.nodes.lines, sweep.nodes.frequency, np.arange(rows.shape[-1])).round().astype(int)
        mask = rows[:, here]
        missed += float((np.abs(away) ** 2 * mask).sum() + sweep.power_within @ share)
        power += float((np.abs(smooth) ** 2 * mask).sum() + sweep.power_within @ share)
    return float(np.sqrt(missed / power))
