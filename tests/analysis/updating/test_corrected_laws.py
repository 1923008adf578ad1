"""Bands of the laws of a corrected twin: what all temperatures share is not averaged away by a smooth law."""

import numpy as np
import pytest

from analysis.estimates import FittedLaws
from analysis.updating.corrected_twin import smooth_laws

TEMPERATURE = np.arange(0.0, 61.0, 5.0)
SHARED, OWN = 8e-3, 2e-4
"""Of log E: by the thickness of the plate, and by noise."""


def nodes(common: bool) -> FittedLaws:
    count = TEMPERATURE.size
    value = np.stack([21.9 - 0.015 * TEMPERATURE, 0.35 + 1e-3 * TEMPERATURE, np.full(count, -2.6)], axis=1)
    shared = np.full((count, 3, 1), SHARED) if common else None
    return FittedLaws(TEMPERATURE, value, np.full((count, 3), np.hypot(SHARED, OWN)), shared)


def test_the_band_of_e_holds_what_the_declaration_leaves_open() -> None:
    whole, averaged = (smooth_laws(nodes(common), (0.0, 60.0)) for common in (True, False))
    assert whole is not None
    assert averaged is not None
    at = 30.0
    band, narrow = (
        float(laws.sigma(at).youngs_modulus[0] / laws.at(at).youngs_modulus[0]) for laws in (whole, averaged)
    )
    assert band == pytest.approx(SHARED, rel=0.05)
    assert narrow < 0.6 * SHARED  # what the shared error was made of before
