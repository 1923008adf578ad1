from collections.abc import Callable

import numpy as np
import pytest

from analysis.protocol.advice import LOSS_FACTOR, STIFFNESS_CHANGE, advice
from analysis.protocol.protocol import AcquisitionProtocol


def test_a_short_sweep_needs_none(protocol_of: Callable[..., AcquisitionProtocol]) -> None:
    assert advice(protocol_of(sweep={"duration": 2.0}, programme={"ramp_rate": 0.4})) == []


def test_a_long_sweep_on_a_ramp_changes_resonances_by_what_is_said(
    protocol_of: Callable[..., AcquisitionProtocol],
) -> None:
    (said,) = advice(protocol_of(sweep={"duration": 15.0}, programme={"ramp_rate": 0.4}))
    assert "spreads over 0.1 K" in said
    assert "by 2 % of their peaks" in said

    def response(temperature: float) -> complex:
        stiffness = np.exp(-STIFFNESS_CHANGE * temperature) * (1.0 + 1j * LOSS_FACTOR)
        return complex(1.0 / (stiffness - 1.0))  # at the resonance of 0 degrees

    at_its_end = response(0.5 * 15.0 * 0.4 / 60.0)
    assert abs(at_its_end - response(0.0)) / abs(response(0.0)) == pytest.approx(0.02, rel=0.05)


def test_what_is_recommended_needs_no_advice(protocol_of: Callable[..., AcquisitionProtocol]) -> None:
    (said,) = advice(protocol_of(sweep={"duration": 15.0}, programme={"ramp_rate": 0.4}))
    assert "7.5 s or less" in said
    assert advice(protocol_of(sweep={"duration": 7.4}, programme={"ramp_rate": 0.4})) == []
