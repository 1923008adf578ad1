import math
import pickle

import pytest

from drivers.ovens.error import Fault, OvenError
from drivers.ovens.oven import OvenLimits, SetPoint

LIMITS = OvenLimits(-10.0, 65.0, 2.0)


@pytest.mark.parametrize(
    ("asked", "sent"),
    [
        ((60.0, 0.4), (60.0, 0.4)),
        ((100.0, 0.4), (65.0, 0.4)),
        ((-40.0, 5.0), (-10.0, 2.0)),
    ],
)
def test_ramps_are_clamped(asked, sent):
    assert LIMITS.clamp(*asked) == SetPoint(*sent)


@pytest.mark.parametrize("target", [math.nan, math.inf, -math.inf])
def test_a_target_that_is_no_number_is_refused(target):
    with pytest.raises(ValueError, match="target"):
        LIMITS.clamp(target, 1.0)


@pytest.mark.parametrize("rate", [0.0, -0.4, math.nan, math.inf])
def test_a_rate_that_is_no_positive_number_is_refused(rate):
    with pytest.raises(ValueError, match="rate"):
        LIMITS.clamp(20.0, rate)


@pytest.mark.parametrize(
    "limits", [(65.0, -10.0, 2.0), (math.nan, 65.0, 2.0), (-300.0, 65.0, 2.0), (0.0, 60.0, 0.0)]
)
def test_limits_that_are_none_are_refused(limits):
    with pytest.raises(ValueError, match=r"limits|max_rate"):
        OvenLimits(*limits)


def test_errors_say_what_happened_and_what_to_do_and_travel_between_processes():
    error = OvenError(Fault.REFUSED, "the chamber refuses", "Take the protection off.", "NA:PROTECT ON")
    assert str(error) == (
        "oven refused: the chamber refuses (the controller says NA:PROTECT ON). Take the protection off."
    )
    again = pickle.loads(pickle.dumps(error))  # noqa: S301 (bytes made one line above)
    assert (again.fault, again.what, again.advice, again.code) == (
        error.fault,
        error.what,
        error.advice,
        error.code,
    )
