"""Relative misfit of a fit over the measured lines."""

import numpy as np

from analysis.arrays import Real
from analysis.gap.data.sweeps import GapSweeps
from analysis.gap.fitting.gap_fit import GapFit


def relative_misfit(sweeps: GapSweeps, fit: GapFit) -> float:
    """rms|H_data - H_twin| / rms|H_data| over all lines, channels and sweeps used."""
    missed, power = sweep_powers(sweeps, fit)
    return float(np.sqrt(missed.sum() / power.sum()))


def sweep_powers(sweeps: GapSweeps, fit: GapFit) -> tuple[Real, Real]:
    """Sum |H_data - H_twin|^2 and |H_data|^2 over the lines and channels of each sweep, (T,) each, (V/V)^2.

    The data are the lines themselves, including their noise about the splines.
    """
    missed, power = np.zeros(sweeps.count), np.zeros(sweeps.count)
    for s, sweep in enumerate(sweeps.compressed):
        rows = sweeps.rows[s]
        smooth = sweep.nodes.at_lines(sweep.coefficients)
        away = sweep.nodes.at_lines(sweep.coefficients - fit.predicted[s])
        share = rows.mean(-1)
        here = np.interp(sweep.nodes.lines, sweep.nodes.frequency, np.arange(rows.shape[-1])).round().astype(int)
        mask = rows[:, here]
        missed[s] = (np.abs(away) ** 2 * mask).sum() + sweep.power_within @ share
        power[s] = (np.abs(smooth) ** 2 * mask).sum() + sweep.power_within @ share
    return missed, power
