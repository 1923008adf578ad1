import numpy as np
import pytest

from analysis.protocol.advice import LOSS_FACTOR, STIFFNESS_CHANGE, change_within_sweep


def test_a_short_sweep_or_a_resting_plate_needs_none() -> None:
    assert change_within_sweep(2.0, 0.4) == change_within_sweep(60.0, 0.0) == ()


def test_a_long_sweep_on_a_ramp_changes_resonances_by_what_is_said() -> None:
    (said,) = change_within_sweep(15.0, 0.4)
    assert "spreads over 0.1 K" in said
    assert "by 2 % of their peaks" in said

    def response(temperature: float) -> complex:
        stiffness = np.exp(-STIFFNESS_CHANGE * temperature) * (1.0 + 1j * LOSS_FACTOR)
        return complex(1.0 / (stiffness - 1.0))  # at the resonance of 0 degrees

    at_its_end = response(0.5 * 15.0 * 0.4 / 60.0)
    assert abs(at_its_end - response(0.0)) / abs(response(0.0)) == pytest.approx(0.02, rel=0.05)


def test_what_is_recommended_needs_no_advice() -> None:
    (said,) = change_within_sweep(15.0, 0.4)
    assert "7.5 s or less" in said
    assert change_within_sweep(7.4, 0.4) == ()
