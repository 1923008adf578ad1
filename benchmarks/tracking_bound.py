"""What the sweeps of a campaign say for a mode at most, for `tracking.py --bound` to print.

All true modes are fitted to all sweeps together, from their true poles, so that no search can fail; then again
without one of them. How much the sum of squares rises is all that the data have for that mode.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analysis.identification.averaging import averaged
from analysis.identification.over_temperature.joint_fit import JointFit, fit_together
from analysis.identification.over_temperature.smooth_tracks import SmoothTracks
from analysis.identification.over_temperature.sweep_fits import sum_of_squares
from analysis.identification.over_temperature.tracking import sweep_measured
from analysis.identification.over_temperature.tracks_without_twin import HIDDEN_SCATTER
from analysis.identification.pole_residue import COMPLEX_E_F_G, to_parameters
from analysis.recordings.frf import Frf

OUT_OF_BAND = 0.08
"""Share of the band's edges up to which modes outside it are fitted as well."""


@dataclass(frozen=True)
class Worth:
    """What one mode is worth.

    Attributes
    ----------
    rise : float
        Of the sum of squares without it, all others fitted again, in one number's variance; their departure from
        smooth tracks included.
    price : float
        What BIC asks for a residue of its own in every sweep that holds it.
    """

    rise: float
    price: float


def worth(frf: Frf, poles: NDArray[np.complex128], modes: list[int]) -> dict[int, Worth]:
    """Return the worth of some of the true modes, poles (T, J) in rad/s."""
    blocks = [averaged(sweep_measured(frf, t).lines()) for t in range(len(poles))]
    terms = [COMPLEX_E_F_G] * len(blocks)
    price = np.array([2.0 * len(one.h) * np.log(one.independent) for one in blocks])
    place, (low, high) = poles.imag / (2.0 * np.pi), frf.frequency[[0, -1]]
    active = (place > low * (1.0 - OUT_OF_BAND)) & (place < high * (1.0 + OUT_OF_BAND))

    def fitted(start: NDArray[np.float64], taking_part: NDArray[np.bool_]) -> tuple[JointFit, float]:
        tracks = SmoothTracks.polynomials(frf.temperature, np.zeros_like(start))
        tracks = replace(tracks, scatter=np.array(HIDDEN_SCATTER))
        now = fit_together(blocks, terms, start, taking_part, tracks)
        numbers = now.search.nearest(now.place, np.zeros(tracks.count), tracks.scatter)
        return now, sum_of_squares(blocks, now) + float(np.sum(now.search.departure(now.place, numbers)))

    every, total = fitted(np.stack([to_parameters(row) for row in poles]), active)
    found = {}
    for j in modes:
        others = active.copy()
        others[:, j] = False
        found[j] = Worth(fitted(every.place, others)[1] - total, float(active[:, j] @ price))
    return found
