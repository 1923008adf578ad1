"""A force that was measured needs no gain: where the twin wants one, a unit or a sensitivity is wrong."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from analysis.channel import Channel, Quantity
from app.summaries.update import gain_notes


def said(gain: float, quantity: Quantity = "force", missed: float = 0.1) -> list[str]:
    found: Any = SimpleNamespace(gains=np.array([gain]), misfit=np.array([missed]))
    return gain_notes(found, [Channel("hammer", quantity, patch=0)], (40.0, 600.0))


@pytest.mark.parametrize("gain", [1.0, 0.6, 1.8, -1.01])
def test_a_calibrated_hammer_is_not_doubted(gain: float) -> None:
    assert said(gain) == []


@pytest.mark.parametrize(
    ("gain", "words"),
    [
        (0.00101, "990 times too small (m and mm, or V and mV are that much apart)"),
        (9.93, "9.93 times too large (g and m/s2 are that much apart)"),
        (4.5, "(lbf and N are that much apart)"),
        (3.0, "the FRFs are 3 times too large. Correct units or sensitivity"),
    ],
)
def test_a_wrong_unit_is_told_and_named(gain: float, words: str) -> None:
    (note,) = said(gain)
    assert words in note


@pytest.mark.parametrize("gain", [6.8e-4, 1500.0, 4.6e-7])
def test_velocity_declared_as_acceleration_is_off_by_the_angular_frequency(gain: float) -> None:
    """Mobility declared as accelerance had only its factor told, 1470; that is 234 Hz in a band of 40 to 600."""
    (note,) = said(gain, missed=0.99)
    assert "displacement, velocity and acceleration, one of them declared for another, are that much apart" in note
    assert "declared for another" not in said(gain)[0]
    assert "declared for another" not in said(10.0, missed=0.99)[0]


def test_an_amplifier_may_have_any_gain() -> None:
    assert said(16.5, "voltage") == []
