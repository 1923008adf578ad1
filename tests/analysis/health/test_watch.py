"""A panel in closed form watches itself: what it says of itself when healthy and when changed."""

import numpy as np
import pytest

from analysis.health.recording import temperature_found
from analysis.health.watch import HealthWatch, NamedChange
from analysis.twin_model import NO_EFFECTS, Effects
from tests.analysis.health.healthy_panel import measured, recorded, usual_watch

CHANGES: dict[str, Effects] = {
    "damage": {"local_damage": {"loss": 0.2, "x": 0.13, "y": 0.07}},
    "mass": {"mass_at_place": {"mass": 0.002, "x": 0.06, "y": 0.11}},
    "bond": {"patch_debond": {"A1": 0.0, "A2": 0.1, "S1": 0.0, "S2": 0.0}},
    "support": {"spring_at_place": {"stiffness": 800.0, "x": 0.2, "y": 0.05}},
}


def changed(effects: Effects, seed: int = 0) -> tuple[HealthWatch, NamedChange]:
    """Two healthy dates, then two with a change."""
    watch, rng = usual_watch(), np.random.default_rng(seed)
    for week, temperature in enumerate((34.6, 13.2, -6.6, 24.5)):
        date = watch.take(
            recorded(measured(temperature, rng, effects if week > 1 else NO_EFFECTS), f"week {week}")
        )
        assert date.alarm == (week > 1), date
    return watch, watch.named()


@pytest.mark.parametrize(
    "family", ["damage", "mass", *(pytest.param(one, marks=pytest.mark.slow) for one in ("bond", "support"))]
)
def test_a_change_is_found_named_and_placed(family: str) -> None:
    effects = CHANGES[family]
    watch, named = changed(effects)
    assert named.family == family
    assert named.probability > 0.95
    ((_, wanted),) = effects.items()
    change = named.change
    assert change is not None
    for name, sigma in change.sigma.items():
        # sigma holds the error of the twin, of which this is one draw
        assert change.values[name] == pytest.approx(wanted[name], abs=5.0 * sigma + 1e-9), name
    if "x" in wanted:
        assert np.hypot(change.values["x"] - wanted["x"], change.values["y"] - wanted["y"]) < 0.002
    assert watch.report().first_alarm == watch.dates[2]


@pytest.mark.slow
@pytest.mark.parametrize(("mass", "x", "y"), [(0.008, 0.028, 0.022), (0.004, 0.191, 0.025)])
def test_a_large_mass_between_the_places_of_the_search_is_named(mass: float, x: float, y: float) -> None:
    """Resonances move by more than their widths: derivatives of the healthy panel mislead."""
    watch, rng = usual_watch(), np.random.default_rng(1)
    heavy = {"mass_at_place": {"mass": mass, "x": x, "y": y}}
    for temperature in (34.6, 13.2):
        assert watch.take(recorded(measured(temperature, rng, heavy))).alarm
    named = watch.named()
    assert named.family == "mass"
    assert named.change is not None
    found = named.change.values
    assert np.hypot(found["x"] - x, found["y"] - y) < 0.005
    assert found["mass"] == pytest.approx(mass, rel=0.05)


def test_lost_polarization_is_a_factor_on_one_patch() -> None:
    watch, rng = usual_watch(), np.random.default_rng(2)
    frf = measured(20.0, rng)
    frf.h[:, 0] *= 0.9  # of S1
    assert watch.take(recorded(frf)).alarm
    named = watch.named()
    assert named.change is not None
    assert (named.family, named.change.candidate.patch) == ("depolarization", "S1")
    assert named.change.values["lost"] == pytest.approx(0.1, abs=0.01)


def test_a_change_of_the_temperature_is_none() -> None:
    """Nor is a label that is wrong by ten kelvins: the panel says itself how warm it is."""
    watch = usual_watch()
    for week, temperature in enumerate((-8.0, 3.0, 17.0, 31.0, 44.0, 58.0)):
        date = watch.take(recorded(measured(temperature, np.random.default_rng(week)), f"week {week}"))
        assert not date.alarm, date
        assert date.temperature == pytest.approx(temperature, abs=0.3)


def test_an_even_change_of_the_whole_material_is_no_damage() -> None:
    """Ageing that makes the plate one per cent stiffer looks like a lower temperature, and is taken for it."""
    watch = usual_watch()
    date = watch.take(recorded(measured(30.0, np.random.default_rng(1), stiffer=0.01)))
    assert not date.alarm
    assert date.temperature == pytest.approx(30.0 - 0.01 / 0.007, abs=0.5)


def test_what_no_effect_explains_is_unknown() -> None:
    watch, rng = usual_watch(), np.random.default_rng(4)
    frf = measured(20.0, rng)
    frf.h[:] = np.roll(frf.h, 6, axis=-1)  # 24 Hz to the side, as no plate does
    assert watch.take(recorded(frf)).alarm
    assert watch.named().family == "unknown"


def test_the_temperature_is_found_from_anywhere() -> None:
    watch, rng = usual_watch(), np.random.default_rng(3)
    for temperature in rng.uniform(-9.5, 59.5, 8):
        (recording,) = recorded(measured(float(temperature), rng))
        found = temperature_found(recording, watch.expects, watch.starts)
        assert found == pytest.approx(temperature, abs=0.3)


def test_a_date_beyond_the_baseline_is_skipped() -> None:
    watch = usual_watch()
    date = watch.take(recorded(measured(70.0, np.random.default_rng(1), beyond=True)))
    assert "outside the baseline's" in date.skipped
    assert watch.report().found is None
    with pytest.raises(ValueError, match="no date was judged"):
        watch.named()


@pytest.mark.slow
def test_false_alarms_are_as_rare_as_stated() -> None:
    """Four years of weeks with seasons: one alarm in a thousand weeks is allowed."""
    alarms = 0
    for year in range(4):
        rng = np.random.default_rng(100 + year)
        watch = usual_watch()
        season = 25.0 + 25.0 * np.sin(2.0 * np.pi * np.arange(52) / 52.0) + rng.normal(0.0, 8.0, 52)
        for temperature in np.clip(season, -9.8, 59.8):
            alarms += watch.take(recorded(measured(float(temperature), rng))).alarm
    assert alarms <= 1  # 0.2 expected at most
