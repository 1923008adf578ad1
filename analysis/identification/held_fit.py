"""A fit with modes that are known to be there, each held near the place it is known to have."""

import numpy as np
from numpy.typing import NDArray

from analysis.identification.automatic import Settings, finish_in_order
from analysis.identification.averaging import averaged
from analysis.identification.measured import Measured
from analysis.identification.modes import Modes
from analysis.identification.parameters import Bounds, to_poles
from analysis.identification.pole_search import PoleFit, Prior, fit


def held_fit(
    measured: Measured,
    alone: PoleFit,
    place: NDArray[np.float64],
    deviation: NDArray[np.float64],
    settings: Settings,
) -> tuple[Modes, NDArray[np.int64], NDArray[np.float64]]:
    """Fit FRFs with poles at `place`, each free to move as far as its standard deviation makes likely.

    Parameters
    ----------
    measured : Measured
        One condition.
    alone : PoleFit
        A fit of all its lines: what it leaves over tells the weight of a line against that of a prior.
    place, deviation : (J, 2) ndarray
        Log |pole| and log damping ratio, and how well they are known; infinite where they are not.
    settings : Settings
        Of the judgement.

    Returns
    -------
    Modes, where each pole of `place` stands among them (J,), and how much BIC would rise without it (J,).
    """
    plain = measured.lines()
    lines = measured.reweighted(plain, alone)
    error = lines.correlation * alone.projection.misfit / lines.values  # of one number
    prior = Prior(Bounds.of(plain).clip(place), error * deviation**-2.0)
    warm = fit(averaged(lines), to_poles(prior.place), alone.terms, tolerance=1e-5, prior=prior)
    modes, index, worth = finish_in_order(measured, lines, warm, settings, prior)
    return modes, index.astype(np.int64), worth
