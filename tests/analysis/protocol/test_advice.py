import tomllib
from pathlib import Path

import numpy as np
import pytest

from analysis.experiment import Experiment
from analysis.protocol.objections import (
    LOSS_FACTOR,
    STIFFNESS_CHANGE,
    change_over_repeats,
    change_within_sweep,
    unseen_lag,
)

EXAMPLES = Path(__file__).resolve().parents[3] / "examples"


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


def test_a_lag_is_told_where_no_data_would_show_it() -> None:
    declared = tomllib.loads((EXAMPLES / "pp-plate" / "campaign.toml").read_text())

    def on(directions: tuple[str, ...], reading: str = "air", lag: float = 300.0) -> Experiment:
        ramps = declared["protocol"] | {"directions": directions, "ramp_rate": 0.4}
        table = {"protocol": ramps, "oven": declared["oven"] | {"reading": reading}}
        return Experiment.model_validate(declared | table | {"tolerances": {"plate_lag": lag}})

    for none in (on(("up",), "plate"), on(("up", "down")), on(("up",), lag=0.0)):
        assert unseen_lag(none) == ()
    (said,) = unseen_lag(on(("down",)))
    assert "may be 2 K behind" in said


def test_repeats_on_a_slow_ramp_or_of_a_metal_need_no_advice() -> None:
    assert change_over_repeats(2.4, 3, 1.0, 0.27) == change_over_repeats(30.4, 1, 3.0, 0.27) == ()
    assert change_over_repeats(30.4, 3, 3.0, 5e-4 / 0.01) == ()


def test_the_mean_of_repeats_at_several_temperatures_is_lower_by_what_is_said() -> None:
    assert change_over_repeats(10.4, 3, 3.0, STIFFNESS_CHANGE / LOSS_FACTOR) == ()
    (said,) = change_over_repeats(20.0, 3, 3.0, STIFFNESS_CHANGE / LOSS_FACTOR)
    assert "the 3 repeats of a sweep spread over 2 K" in said
    apart = 20.0 * 3.0 / 60.0

    def response(temperature: float) -> complex:
        stiffness = np.exp(-STIFFNESS_CHANGE * temperature) * (1.0 + 1j * LOSS_FACTOR)
        return complex(1.0 / (stiffness - 1.0))

    mean = sum(response(n * apart) for n in (-1, 0, 1)) / 3
    lower = 100.0 * (1.0 - abs(mean) / abs(response(0.0)))
    stated = float(said.split("by about ")[1].split(" %")[0])
    assert stated == pytest.approx(lower, rel=0.2)
