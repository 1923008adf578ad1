"""Plans on a real twin, for questions whose best measurement is known, and one trial from hiding to the answer."""

from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

from analysis.effect_card import Values
from analysis.gap.fitting.fit import fit_gap
from analysis.gap.plan.decision import Expected, Plan
from analysis.gap.plan.measurement import Reach
from analysis.gap.plan.separation import ENOUGH, Question
from analysis.recordings.frf import Frf
from analysis.twin_model import HeldEffects
from app.blind_trial.effect_size import EffectSize, expected_frf
from app.blind_trial.experiments import draw_experiments
from app.blind_trial.planned import CASES, summary
from app.blind_trial.plates import PlateKind
from app.blind_trial.specimen import Specimen
from app.stages.comparison.compared import Compared
from app.stages.comparison.plan import plan
from simulation.effects.library import LIBRARY
from simulation.reduction.effect_operators import EffectOperators
from simulation.tolerances import tolerances

NOISE = 0.002
"""Of a line over the response: on so few modes an effect of some per cent is then seen."""
REACH = Reach(level=4.0, temperatures=(-10.0, 80.0), rate=3.0, highest=300.0)


class Bench:
    """One ramp at one level on the small plate, seen without effects."""

    def __init__(self, yard: EffectSize, frf: Frf, operators: EffectOperators) -> None:
        self.yard, self.frf = yard, frf
        declared = yard.specimen.declared
        # attachable as real twins are: without, nobody saw that no further sensor could be planned for those
        known = tolerances(declared, operators.movable, attachable=bool(len(operators.places)))
        self.twin = replace(yard.specimen.twin, tolerances=known)

    def planned(self, asked: Sequence[tuple[str, str | None]], on: dict[str, Values] | None = None) -> Plan:
        yard, model = self.yard, HeldEffects.around(self.twin)
        state = yard.state.with_effects(on or {})
        fit = fit_gap(model, yard.sweeps, state, (), yard.executor, gain_free=False, laws_free=False)
        fit = replace(fit, state=state.with_tolerances(model.tolerance_cards))
        compared = Compared(yard.specimen.declared, self.frf, self.twin, model, yard.sweeps, fit)
        questions = [Question(a, b, (on or {}).get(a, {})) for a, b in asked]
        return plan(compared, questions, lambda stage, share: None, yard.executor, {}, REACH)


@pytest.fixture(scope="module")
def bench(kind: PlateKind, operators: EffectOperators) -> Iterator[Bench]:
    experiment = draw_experiments(np.random.default_rng(4), kind, "plate", ("up",), (1.0,))[0]
    with ThreadPoolExecutor(1) as executor:
        specimen = Specimen.of([experiment], operators)
        yard = EffectSize.of(specimen, specimen.twin, NOISE, np.random.default_rng(0), executor)
        frf, _ = expected_frf(specimen, NOISE, np.random.default_rng(0))
        yield Bench(yard, frf, operators)


def by_key(found: Plan) -> dict[str, Expected]:
    assert found.notes == ()
    return {one.measurement.key: one for one in found.ranked}


@pytest.mark.slow
def test_ramps_show_a_lag_and_levels_what_follows_the_drive(bench: Bench) -> None:
    """One ramp at one level shows neither; each of two measurements shows one of them, and no other any."""
    found = by_key(bench.planned([("thermal_lag", None), ("piezo_nonlinearity", None)]))
    lag, drive = 0, 1
    for one in found.values():
        assert one.before[lag] == 0.0
        assert one.before[drive] < ENOUGH
    for key, one in found.items():
        assert (lag in one.settles) == (key in ("both_ramps", "faster_ramp", "thermocouples")), key
    louder = found["second_level"]
    assert drive in louder.settles
    assert louder.after[drive] > 2.0 * max(one.after[drive] for one in found.values() if one is not louder)
    # a lag shows in proportion to the rate
    ratio = found["faster_ramp"].after[lag] / found["both_ramps"].after[lag]
    assert ratio == pytest.approx(2.0, rel=0.15)


@pytest.mark.slow
def test_turning_the_plate_sets_a_draught_and_a_taper_apart(bench: Bench) -> None:
    """More than the same sweeps once more would, which is a factor of the root of two."""
    on: dict[str, Values] = {"thickness_taper": {"tx": 0.05, "ty": 0.0}}
    one = by_key(bench.planned([("thickness_taper", "draught_gradient")], on))["turned_plate"]
    assert one.after[0] > 1.6 * one.before[0]


@pytest.mark.slow
def test_a_cable_is_weighed(bench: Bench) -> None:
    """Its mass and a spot that lost stiffness lower the same few modes; a scale reads the mass to 0.02 g."""
    on: dict[str, Values] = {"point_mass": {"mass": 2e-4}}
    found = by_key(bench.planned([("point_mass", "density_gradient"), ("point_mass", "orthotropy")], on))
    assert found["scale"].after[0] >= found["micrometer"].after[0]
    assert found["scale"].after[0] > found["scale"].before[0]


def test_every_case_of_the_trial_is_of_the_library() -> None:
    for case in CASES:
        assert set(case.effects) <= set(LIBRARY)
        assert len(set(case.effects)) == len(case.effects) > 1


def test_what_was_never_open_does_not_count() -> None:
    rows = [
        {"open": True, "hidden": "a", "settled": "a"},
        {"open": True, "hidden": "a", "settled": None},
        {"open": True, "hidden": "a", "settled": "b"},
        {"open": False, "hidden": "a", "settled": "a"},
    ]
    assert summary(rows).startswith("4 trials, 3 open: 1 settled rightly, 1 wrongly")
