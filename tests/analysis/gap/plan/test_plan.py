"""Measurements for look-alikes and blind spots whose remedy is known: the right one settles, others do not."""

import numpy as np
import pytest

from analysis.effect_card import Parameter
from analysis.gap.data.preparation import prepare
from analysis.gap.fitting.fit import fit_gap
from analysis.gap.plan.decision import NOTHING, Expected, Told, decided, ranked, told, weights
from analysis.gap.plan.measurement import Measurement, laws_at, planned_sweeps, thinned, widened
from analysis.gap.plan.separation import ENOUGH, LinearisedCampaign, Question, separation

TEMPERATURES = tuple(np.arange(2.0, 39.0, 6.0))


class Bench:
    """A toy campaign as a comparison left it, and campaigns that could follow."""

    def __init__(self, toy, pool, effects, asked, **kwargs):
        kwargs.setdefault("temperatures", TEMPERATURES)
        self.toy, self.pool, self.asked = toy, pool, asked
        self.frf, self.rig = toy.record(effects=effects, **kwargs)
        self.plate = toy.Plate(kwargs.get("channels", 2), ())
        self.sweeps, _ = prepare(self.frf, self.rig, toy.updated(self.frf))
        start = toy.start(self.sweeps.groups).with_effects(effects)
        self.fit = fit_gap(self.plate, self.sweeps, start, tuple(effects), pool)
        self.recorded = self.linearised(self.sweeps, self.fit.state).information()

    def linearised(self, sweeps, state):
        return LinearisedCampaign.at(self.plate, sweeps, state, self.fit, self.asked, self.pool)

    def planned(self, **changes):
        rig = self.rig.model_copy(update=changes)
        planned = planned_sweeps(self.frf, self.sweeps, self.fit.state, rig, self.plate.box)
        return self.linearised(*planned).information()

    def question(self, effect, rival=None):
        return Question(effect, rival, self.fit.state.effects.get(effect, {}))


@pytest.fixture(scope="module")
def bench(toy, pool):
    return lambda effects, asked, **kwargs: Bench(toy, pool, effects, asked, **kwargs)


def test_the_same_campaign_once_more_doubles_the_information(bench):
    there = bench({"mass": {"grams": 0.1}}, ("mass", "stretch"))
    again = there.planned()
    np.testing.assert_allclose(np.diag(again.matrix), np.diag(there.recorded.matrix), rtol=0.05)
    question = there.question("mass", "stretch")
    both = separation(question, there.recorded.beside(again))
    assert both == pytest.approx(np.sqrt(2.0) * separation(question, there.recorded), rel=0.05)


def test_a_lag_is_a_blind_spot_on_one_ramp_and_none_on_two(bench):
    there = bench({}, ("lag",), directions=("up",))
    question = there.question("lag")
    assert separation(question, there.recorded) == 0.0
    assert separation(question, there.recorded.beside(there.planned(levels=(1.0, 3.0)))) < 1.0
    assert separation(question, there.recorded.beside(there.planned(directions=("up", "down")))) > ENOUGH


def test_a_second_level_tells_a_mass_from_softening(bench):
    there = bench({"mass": {"grams": 1.0}}, ("mass", "softening"))
    question = there.question("mass", "softening")
    before = separation(question, there.recorded)
    louder = separation(question, there.recorded.beside(there.planned(levels=(1.0, 3.0))))
    slower = separation(question, there.recorded.beside(there.planned(ramp_rate=0.2)))
    assert louder > 2.0 * before
    assert louder > 2.0 * slower


def test_an_expected_separation_is_that_of_a_full_fit(bench):
    """The linearised distance of two small effects is the root of the difference of chi2 of their fits."""
    there = bench({"mass": {"grams": 0.2}}, ("mass", "stretch"))
    start = there.fit.state.with_effects({"stretch": {"delta_e": 0.0, "delta_g": 0.0}})
    other = fit_gap(there.plate, there.sweeps, start, ("stretch",), there.pool)
    apart = np.sqrt((other.total + other.prior - there.fit.total) / there.sweeps.overstated)
    told_by, mass, stretch = there.recorded.matrix, [0], [1, 2]
    value = there.fit.state.effects["mass"]["grams"]
    pull = told_by[np.ix_(stretch, mass)][:, 0] * value
    prior = np.diag([c.card.sigma**-2.0 for c in there.recorded.columns[1:]])
    shared = pull @ np.linalg.solve(told_by[np.ix_(stretch, stretch)] + prior, pull)
    power = value**2 * told_by[0, 0]
    one_way = np.sqrt(power - shared)
    assert one_way == pytest.approx(apart, rel=0.1)
    # the other way round the imitation, which is the smaller signal, is the true one
    expected = one_way * np.sqrt(shared / power)
    assert separation(there.question("mass", "stretch"), there.recorded) == pytest.approx(expected, rel=0.02)


def test_look_alikes_of_any_size_are_not_set_apart(bench):
    """Signals of a cosine of 0.995 are one class: other errors of a tenth could exchange them."""
    there = bench({"taper": {"tx": 0.01}}, ("taper", "draught"), noise=1e-3)
    assert separation(there.question("taper", "draught"), there.recorded) < ENOUGH


def test_turning_the_plate_tells_what_is_fixed_to_the_oven(bench):
    there = bench({"taper": {"tx": 0.0003}}, ("taper", "draught"))
    question, again = there.question("taper", "draught"), there.planned()
    repeated = separation(question, there.recorded.beside(again))
    turned = separation(question, there.recorded.beside(again.turned(("draught",))), {}, there.recorded)
    assert turned > 1.5 * repeated


def test_a_reading_by_hand_counts_as_its_distance_from_nothing(bench):
    there = bench({"taper": {"tx": 0.0003}}, ("taper", "draught"))
    question = there.question("taper", "draught")
    value = there.fit.state.effects["taper"]["tx"]
    block = np.ix_(there.recorded.of("taper"), there.recorded.of("taper"))
    power = value**2 * there.recorded.matrix[block].item()
    # a draught in truth: a taper of which 1/6 of the value is read at most would have to explain its signal
    expected = np.sqrt(36.0 * power / (36.0 + power))
    one = separation(question, there.recorded, {("taper", "tx"): value / 6.0})
    assert one == pytest.approx(expected, rel=0.1)
    blind = there.question("taper")
    assert separation(there.question("draught"), there.recorded, {("draught", "gx"): 1e-3}) > 1000.0
    assert blind.kind == "blind spot"


@pytest.mark.parametrize("band", [(100.0, 1499.3), (100.0, 1500.0), (80.5, 1800.7), (300.0, 900.0)])
def test_planned_lines_fill_the_band_and_do_not_leave_it(bench, band):
    """A twin is certified over its band only, whose ends need not be lines of the recording."""
    there = bench({}, ("mass",))
    rig = there.rig.model_copy(update={"band": band})
    sweeps, _ = planned_sweeps(there.frf, there.sweeps, there.fit.state, rig, there.plate.box)
    lines = sweeps.nodes.lines
    assert band[0] <= lines[0] < band[0] + 3.0  # lines of mains harmonics are left out
    assert band[1] - 3.0 < lines[-1] <= band[1]


def test_laws_go_on_in_straight_lines_beyond_the_campaign(bench):
    there = bench({}, ("mass",))
    at = np.array([-20.0, -10.0, 0.0, 14.0])
    laws = laws_at(there.sweeps, there.fit.state, at)
    inner = laws_at(there.sweeps, there.fit.state, there.sweeps.groups.reference)
    np.testing.assert_allclose(inner, there.fit.state.laws, atol=1e-12)
    np.testing.assert_allclose(laws[1] - laws[0], laws[2] - laws[1], atol=1e-9)


def test_what_settles_a_question_comes_before_what_is_only_quick():
    quick, sure = Measurement("scale", "weigh", 0.1), Measurement("both_ramps", "both", 8.0)
    far, near = (Measurement("further_sensor", "there", 2.0, place=(x, 0.0)) for x in (0.1, 0.2))
    question = Question("lag")
    plan = ranked(
        [question],
        [
            Expected(quick, (0.0,), (3.0,), (1.0,)),
            Expected(sure, (0.0,), (30.0,), (1.0,)),
            Expected(far, (0.0,), (2.0,), (1.0,)),
            Expected(near, (0.0,), (2.5,), (1.0,)),
        ],
    )
    assert [one.measurement.key for one in plan.ranked] == ["both_ramps", "scale", "further_sensor"]
    assert plan.ranked[2].measurement is near
    assert plan.winner is not None
    assert plan.winner.gain == ENOUGH
    assert plan.winner.settles == (0,)
    assert ranked([question], [Expected(quick, (7.0,), (9.0,), (1.0,))]).winner is None


def test_the_name_of_what_was_found_counts_more_than_what_nobody_saw():
    open_name, blind = Question("taper", "draught", {"tx": 0.01}), Question("lag")
    both, turned = Measurement("both_ramps", "both", 2.0), Measurement("turned_plate", "turn", 2.0)
    count = weights([open_name, blind])
    expected = [Expected(both, (2.0, 0.0), (2.0, 99.0), count), Expected(turned, (2.0, 0.0), (9.0, 0.0), count)]
    plan = ranked([open_name, blind], expected)
    assert plan.winner is not None
    assert plan.winner.measurement is turned


def test_temperatures_are_thinned_and_widened_by_whole_steps():
    assert thinned(tuple(range(0, 62, 2))) == (0, 8, 16, 24, 32, 40, 48, 56)
    assert thinned((10.0, 20.0)) == (10.0, 20.0)
    assert widened((0.0, 10.0, 20.0, 30.0)) == (-10.0, 0.0, 10.0, 20.0, 30.0, 40.0)


def test_no_hours_are_no_measurement():
    with pytest.raises(ValueError, match="0 hours"):
        Measurement("scale", "weigh", 0.0)


def test_two_campaigns_decide_what_one_could_not(bench):
    """The truth is a taper; the plate was turned for the second campaign, so a draught would change sides."""
    there = bench({"taper": {"tx": 0.0002}}, ("taper", "draught"))
    first = told(there.plate, there.sweeps, there.fit.state, there.asked, there.pool)
    assert [one.effect for one in first] == [NOTHING, "taper", "draught"]
    again = Bench(there.toy, there.pool, {"taper": {"tx": 0.0002}}, there.asked, seed=5)
    second = told(again.plate, again.sweeps, again.fit.state, again.asked, there.pool)
    decision = decided(first, second, ("draught",))
    assert decision.settled == "taper"
    assert decided(first, second).nats["draught"] > decision.nats["draught"] + 10.0
    assert decided(first).settled is None


def test_a_reading_by_hand_decides_in_proportion_to_its_distance(bench):
    there = bench({"taper": {"tx": 0.0002}}, ("taper", "draught"))
    first = told(there.plate, there.sweeps, there.fit.state, there.asked, there.pool)
    assert decided(first, readings=[("taper", "tx", 0.0002, 2e-5)]).settled == "taper"
    assert decided(first, readings=[("taper", "tx", 0.0, 2e-5)]).settled == "draught"
    assert decided(first, readings=[("taper", "tx", 0.0002, 1.0)]).settled is None


def test_the_evidence_of_two_halves_is_that_of_the_whole():
    """One Gaussian parameter: the closed form of both data at once."""
    card = Parameter("p", "1", -10.0, 10.0, 2.0)

    def evidence(value, variance):  # of data that say value +- root of the variance
        return -0.5 * value**2 / (4.0 + variance) - 0.5 * np.log(4.0 + variance) + 0.5 * np.log(variance)

    def of(value, variance):
        shrunk = 4.0 / (4.0 + variance)
        return Told("p", (card,), np.array([value]), np.array([[variance]]), evidence(value, variance)), shrunk

    (one, _), (other, _) = of(1.0, 0.01), of(1.1, 0.02)
    variance = 1.0 / (1.0 / 0.01 + 1.0 / 0.02)
    value = variance * (1.0 / 0.01 + 1.1 / 0.02)
    spread = 0.01 + 0.02
    known = evidence(value, variance) - 0.5 * 0.1**2 / spread
    joint = one.beside(other, turned=False)
    assert joint.values[0] == pytest.approx(value)
    assert joint.covariance[0, 0] == pytest.approx(variance)
    assert joint.log_evidence == pytest.approx(known, abs=0.02)
