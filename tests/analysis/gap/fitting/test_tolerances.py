"""Declared quantities with a tolerance are free in every fit, and widen the laws' bands."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from analysis.gap.fitting.fit import KnownDerivatives, fit_gap
from analysis.gap.gap import find_gap
from analysis.twin_model import NO_EFFECTS

TOLERANCES = {"mass": 1.0, "stretch": 0.01}
"""Of the toy's mass, g, and of both its moduli."""


@pytest.fixture
def tolerant(toy):
    """Toy whose mass and anisotropy are declared with a tolerance, and are no candidates."""

    @dataclass
    class Tolerant(toy.Plate):
        @property
        def tolerance_cards(self):
            return {
                name: replace(
                    toy.cards[name],
                    parameters=tuple(
                        replace(p, sigma=sigma, low=-8.0 * sigma, high=8.0 * sigma)
                        for p in toy.cards[name].parameters
                    ),
                )
                for name, sigma in TOLERANCES.items()
            }

        @property
        def cards(self):
            return {name: card for name, card in super().cards.items() if name not in TOLERANCES}

    return Tolerant()


DRAWN = {"mass": {"grams": 0.8}, "stretch": {"delta_e": -0.007, "delta_g": 0.004}}


def test_they_are_found_and_the_laws_are_within_their_bands(toy, tolerant, pool):
    sweeps, _ = toy.prepared(effects=DRAWN, reading_sigma=0.0)
    fit = fit_gap(tolerant, sweeps, toy.start(sweeps.groups), (), pool)
    true = toy.laws(sweeps.groups.reference)
    away = np.abs(fit.state.laws - true) / fit.stated.laws
    assert (away < 3.0).mean() > 0.95
    for one in fit.declared_quantities(tolerant.tolerance_cards):
        assert abs(one.value - DRAWN[one.name][one.parameter]) < 3.0 * one.sigma
        assert one.sigma <= one.tolerance * (1.0 + 1e-9)


def test_without_them_a_stated_deviation_is_many_times_too_small(toy, tolerant, pool):
    sweeps, _ = toy.prepared(effects=DRAWN, reading_sigma=0.0)
    start = toy.start(sweeps.groups)
    exact, free = (fit_gap(model, sweeps, start, (), pool) for model in (toy.Plate(), tolerant))
    away = np.abs(exact.state.laws - toy.laws(sweeps.groups.reference))[:, 0]
    assert (away / exact.noise.laws[:, 0]).mean() > 5.0
    assert (exact.noise.laws < free.noise.laws)[:, 0].all()


def test_a_quantity_that_no_line_tells_keeps_its_tolerance(toy, tolerant, pool):
    """A common factor on all moduli of the toy is its E: what a tolerance of it leaves open is the law's band."""
    sweeps, _ = toy.prepared(effects={})
    fit = fit_gap(tolerant, sweeps, toy.start(sweeps.groups), (), pool)
    whole, common = fit.stated.laws**2, (fit.stated.common**2).sum(axis=2)
    assert (common < whole * (1.0 + 1e-9)).all()
    # an error that all temperatures share is told from that which each has for itself, and nothing is lost
    found = fit.fitted_laws(sweeps.groups.reference)
    np.testing.assert_allclose(found.own_sigma**2 + (found.shared**2).sum(-1), found.sigma**2, rtol=1e-9)
    assert (found.shared[:, 0] ** 2).sum(-1).min() > 0.5 * (found.sigma[:, 0] ** 2).min()
    # the same from the joint covariance: a law's variance is that at known quantities, and what these add
    held = fit_gap(toy.Plate(), sweeps, fit.state.with_effects({}), (), pool)
    assert (held.noise.laws**2 <= fit.noise.laws**2 + 1e-18).all()


def test_nothing_is_claimed_of_a_careful_declaration(toy, tolerant, pool):
    frf, rig = toy.record(effects=DRAWN)
    report = find_gap(frf, toy.updated(frf), tolerant, rig, pool)
    assert report.verdict == "none"
    assert {one.name for one in report.declared} == set(TOLERANCES)
    assert not any(one.beyond for one in report.declared)


def test_an_effect_is_named_beside_errors_of_the_declaration(toy, tolerant, pool):
    frf, rig = toy.record(effects={**DRAWN, "damage": {"loss": 0.3, "x": 0.31}})
    report = find_gap(frf, toy.updated(frf), tolerant, rig, pool)
    assert [effect.name for effect in report.effects] == ["damage"]
    found = {p.name: p for p in report.effects[0].parameters}
    assert abs(found["loss"].value - 0.3) < 3.0 * found["loss"].sigma


def test_a_declaration_that_is_wrong_is_said_in_words(toy, tolerant, pool):
    frf, rig = toy.record(effects={"mass": {"grams": 6.0}})
    report = find_gap(frf, toy.updated(frf), tolerant, rig, pool)
    assert any(note.startswith("the declaration is doubtful: toy mass") for note in report.notes)
    assert [one.name for one in report.declared if one.beyond] == ["mass"]


def test_a_twin_is_asked_for_the_effect_behind_a_quantity_that_is_beyond(toy, tolerant, pool):
    """An effect that costs operators of its own is there only where a declared quantity says that it may be."""
    asked = []

    class Richer(type(tolerant)):
        __hash__ = object.__hash__

        def __eq__(self, other):
            raise ValueError("twins hold arrays of different shapes, which cannot be compared")

        @property
        def cards(self):
            return {**super().cards, "heavier": replace(toy.cards["mass"], name="heavier", replaces="mass")}

        def named(self, effects):
            return {("mass" if name == "heavier" else name): values for name, values in effects.items()}

        def frf(self, laws, frequency, effects=None, point=None):
            return super().frf(laws, frequency, self.named(effects or {}), point)

        def linearise(self, laws, frequency, effects=None, point=None, tangents=()):
            known = [("mass" if name == "heavier" else name, *rest) for name, *rest in tangents]
            return super().linearise(laws, frequency, self.named(effects or {}), point, known)

    def remade(declared):
        asked.append(declared["mass"]["grams"])
        return None if len(asked) > 1 else Richer()

    frf, rig = toy.record(effects={"mass": {"grams": 6.0}})
    report = find_gap(frf, toy.updated(frf), tolerant, rig, pool, remade=remade)
    assert asked[0] == pytest.approx(6.0, rel=0.2)
    assert [effect.name for effect in report.effects] == ["heavier"]
    asked.clear()
    frf, rig = toy.record(effects=DRAWN)
    find_gap(frf, toy.updated(frf), tolerant, rig, pool, remade=remade)
    assert not asked


def counting(model, asked):
    """Return the model; it appends to `asked` by how many declared quantities each sweep is differentiated."""

    @dataclass
    class Counting(type(model)):
        def linearise(self, laws, frequency, effects=NO_EFFECTS, point=None, tangents=()):
            asked.append(sum(name in TOLERANCES for name, *_ in tangents))
            return super().linearise(laws, frequency, effects, point, tangents)

    return Counting()


def test_a_fit_begins_with_the_derivatives_of_one_before_it(toy, tolerant, pool):
    """Of two fits from one point, as a search makes them, the second does not ask for what it knows there."""
    sweeps, _ = toy.prepared(effects=DRAWN, reading_sigma=0.0)
    base = fit_gap(tolerant, sweeps, toy.start(sweeps.groups), (), pool)
    begun = replace(base.state, effects={**base.state.effects, "damage": {"loss": 0.0, "x": 0.35}})
    known, asked = KnownDerivatives(), ([], [])
    first, second = (
        fit_gap(counting(tolerant, one), sweeps, begun, ("damage",), pool, known=known) for one in asked
    )
    assert np.count_nonzero(asked[1]) < np.count_nonzero(asked[0])
    assert abs(second.total - first.total) < 0.1
    np.testing.assert_allclose(second.state.laws, first.state.laws, atol=0.02 * first.stated.laws.max())
    np.testing.assert_allclose(second.stated.laws, first.stated.laws, rtol=0.01)


def test_known_derivatives_lead_where_all_derivatives_lead(toy, tolerant, pool, monkeypatch):
    """Derivatives by declared quantities that are taken from a point near by cost no accuracy."""
    sweeps, _ = toy.prepared(effects={**DRAWN, "damage": {"loss": 0.3, "x": 0.31}}, reading_sigma=0.0)
    begun = replace(toy.start(sweeps.groups), effects={"damage": {"loss": 0.0, "x": 0.35}})
    asked = []
    near = fit_gap(counting(tolerant, asked), sweeps, begun, ("damage",), pool)
    cheap = asked.count(0) - sweeps.count  # the first point, with the quantities held, is one of them
    asked.clear()
    monkeypatch.setattr("analysis.gap.fitting.fit.NEAR", -1.0)
    all_anew = fit_gap(tolerant, sweeps, begun, ("damage",), pool)
    assert cheap > 0
    assert near.settled
    assert near.total - all_anew.total < 1.0
    np.testing.assert_allclose(near.state.laws, all_anew.state.laws, atol=0.1 * all_anew.stated.laws.max())
    away = np.array([near.state.on[n][p] - all_anew.state.on[n][p] for n, p in near.free.names])
    assert (np.abs(away) < 0.1 * all_anew.stated.parameters).all()
    np.testing.assert_allclose(near.stated.parameters, all_anew.stated.parameters, rtol=0.02)
