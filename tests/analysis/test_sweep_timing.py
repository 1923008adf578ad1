import numpy as np
import pytest

from analysis.experiment import Protocol
from analysis.protocol.sweep import SweepTiming

DECLARED = {
    "sweep": "logarithmic",
    "band": (100.0, 1600.0),
    "sweep_duration": 2.0,
    "tail": 0.4,
    "repeats": 3,
    "ramp_rate": 1.0,
    "temperatures": (0.0, 10.0),
    "directions": ("up",),
    "levels": (1.0,),
}


def test_the_edges_are_passed_a_taper_from_the_ends_and_the_middle_halfway() -> None:
    for kind, middle in (("logarithmic", 400.0), ("linear", 850.0)):
        timing = SweepTiming(kind, (100.0, 1600.0), 0.1, 2.0, 2.4)  # type: ignore[arg-type]
        assert timing.passed_at(np.array([100.0, middle, 1600.0])) == pytest.approx([0.1, 1.0, 1.9])
        assert timing.after_middle(np.array([100.0, middle, 1600.0])) == pytest.approx([-1.1, -0.2, 0.7])


def test_a_protocol_has_a_timing_where_its_taper_is_declared() -> None:
    assert Protocol.model_validate(DECLARED).timing is None
    timed = Protocol.model_validate({**DECLARED, "taper": 0.1})
    assert timed.timing == SweepTiming("logarithmic", (100.0, 1600.0), 0.1, 2.0, 2.4)


def test_a_taper_without_time_for_the_band_is_refused() -> None:
    with pytest.raises(
        ValueError, match=r"taper 0.6 s is more than a quarter of sweep_duration \(2 s\); at most 0.5 s"
    ):
        Protocol.model_validate({**DECLARED, "taper": 0.6})
