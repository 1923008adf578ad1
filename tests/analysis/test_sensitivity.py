"""Volts at the cards become units of the plate."""

import numpy as np
import pytest

from analysis.channel import Channel, Footprint
from analysis.recordings.campaign import Sensitivities, Sensitivity, Sweep

PLACE = Footprint((0.1, 0.1))
FORCE, ACCELERATION = (Channel(name, name, footprint=PLACE) for name in ("force", "acceleration"))
VOLTS = Channel("S1", "voltage", patch=0)


def sweep() -> Sweep:
    samples = np.random.default_rng(1).standard_normal((3, 2, 50)).astype(np.float32)
    return Sweep(0, "up", 1.0, 20.0, 20.0, "2000-01-01T00:00:00", samples[0], samples[1:])


def test_volts_are_divided_by_volts_per_unit() -> None:
    recorded = sweep()
    found = Sensitivities(Sensitivity(FORCE, 0.1), (Sensitivity(VOLTS), Sensitivity(ACCELERATION, 0.01)))
    measured = found.measured(recorded)
    assert found.units == ("N", "V", "m/s2")
    np.testing.assert_allclose(measured.drive, 10.0 * recorded.drive, rtol=1e-6)
    np.testing.assert_allclose(measured.responses[1], 100.0 * recorded.responses[1], rtol=1e-6)
    assert measured.drive.dtype == measured.responses.dtype == np.float32
    assert measured.responses[0].tobytes() == recorded.responses[0].tobytes()  # volts, bit by bit


def test_nonsense_is_refused() -> None:
    with pytest.raises(ValueError, match="'force': 0 V/N; above 0 allowed"):
        Sensitivity(FORCE, 0.0)
    with pytest.raises(ValueError, match="'S1' is read in volts, 2 V/V"):
        Sensitivity(VOLTS, 2.0)
    with pytest.raises(ValueError, match="2 responses; 1 sensitivities"):
        Sensitivities(Sensitivity(FORCE, 1.0), (Sensitivity(VOLTS),)).measured(sweep())
