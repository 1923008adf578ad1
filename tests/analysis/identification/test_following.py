"""Poles of one sweep followed to the next."""

import numpy as np
from numpy.typing import NDArray

from analysis.identification.measured import Measured
from analysis.identification.over_temperature.tracks_without_twin import Followed, follow
from analysis.identification.pole_residue import BAND_MARGIN, NONE, REAL_E, synthesis, to_parameters
from analysis.identification.settings import Settings

FREQUENCY = np.arange(100.0, 900.0, 0.5)
AT_ZERO = np.array([170.0, 240.0, 310.0, 455.0, 560.0, 700.0])
STIFFNESS, LOSS = (1.0, 0.858, 0.701), (0.026, 0.0355, 0.0415)
"""Of glass-filled polypropylene at 0, 15 and 30 °C, relative."""


def poles(sweep: int) -> NDArray[np.complex128]:
    return 2j * np.pi * AT_ZERO * np.sqrt(STIFFNESS[sweep] * (1 + 1j * LOSS[sweep]))


def test_poles_found_afresh_continue_the_tracks_where_the_trend_ends() -> None:
    """The trend of 30 and 15 °C misses 0 °C by two half widths, and a mode appears there that is not followed.

    The sweep is identified afresh. Its poles were matched to none of the predicted ones, and continued as new
    tracks beside the old ones: two poles shared each mode of the joint fit.
    """
    place = np.full((3, 6, 2), np.nan)
    place[1], place[2] = to_parameters(poles(1)), to_parameters(poles(2))
    known = Followed(np.array([0.0, 15.0, 30.0]), REAL_E, place, np.ones(6, dtype=bool), [2, 1], BAND_MARGIN)
    predicted = known.predicted(0)[0][:, 0] - to_parameters(poles(0))[:, 0]
    assert np.abs(predicted).min() > 1.8 * LOSS[0] / 2.0
    here = np.append(poles(0), 2j * np.pi * 640.0 * np.sqrt(1 + 1j * LOSS[0]))
    residues = 1j * np.array([[100.0, -120, 150, 130, -160, 200, 180]])
    clean = synthesis(FREQUENCY, here, residues, NONE, np.zeros((1, 0), complex))
    deviation = 1e-3 * np.sqrt(np.mean(np.abs(clean) ** 2))
    draw = np.random.default_rng(0).normal(size=(2, *clean.shape))
    h = clean + deviation / np.sqrt(2) * (draw[0] + 1j * draw[1])
    follow(known, 0, Measured(FREQUENCY, h, np.full(h.shape, deviation**2)), 1e-3, Settings())
    assert known.place.shape[1] == 7
    np.testing.assert_allclose(known.place[0, :6], to_parameters(poles(0)), rtol=1e-3)
