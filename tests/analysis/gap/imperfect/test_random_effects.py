"""Evidence beside modes that scatter, against a joint normal density and drawn scatter."""

from dataclasses import replace

import numpy as np
import pytest

from analysis.gap.fitting.linearised_sweeps import LinearisedSweeps
from analysis.gap.imperfect.random_effects import FINENESS, SPAN, WITH_TEMPERATURE, RandomEffects
from analysis.gap.thresholds import NODES_PER_HALF_WIDTH


@pytest.fixture(scope="module")
def judged(scattered):
    """Linearise a campaign whose modes are off by 0.3 % in frequency and 1.5 % in size."""
    context, fit = scattered(3, 0.003, 0.015)
    linear = LinearisedSweeps.of(context.model, context.sweeps, fit.state, context.executor)
    return RandomEffects.of(linear, context.sweeps)


def joint_density(judged, found, name):
    """Log density of the residual, up to what no effect changes, by the singular values of one matrix.

    It has all numbers of all sweeps and all unknowns, each in standard deviations of its prior; laws and gains
    have priors so wide that they do not matter.
    """
    linear, sweeps = judged.linear, judged.sweeps
    state, card = linear.state, linear.cards[name]
    error = sweeps.twin_error * FINENESS**found.place
    temperature = np.array([state.circumstances(s, one).temperature for s, one in enumerate(sweeps.points)])
    warm = (temperature - temperature.mean()) / SPAN
    a, b, c = np.exp(found.modes)
    columns = [linear.column((name, p.name, card.zero(card.sites[0]))) for p in card.amplitudes]
    rows, residual = [], []
    for s, white in enumerate(linear.white):
        strength = judged._strength[s]
        weight = 1.0 / np.sqrt(1.0 + NODES_PER_HALF_WIDTH * sweeps.count * error**2 * strength)
        parts, gain = judged.parts[s], np.exp(state.log_gain[0])
        shift, part = (
            gain * sweeps.compressed[s].whitened(sweeps.nodes.coefficients(p))
            for p in (parts.by_pole, parts.parts)
        )
        channels = np.eye(len(sweeps.channels))[:, :, None]
        single = (part[:, None] * channels[None]).reshape(-1, *part.shape[1:])
        steady = [a * shift, 1j * b * shift, np.sqrt(0.5) * c * single, 1j * np.sqrt(0.5) * c * single]
        steady = np.concatenate(steady)
        own = np.einsum("ckn,cl->lkn", white.white[:10], judged._own[s])
        local = np.sqrt(1.0 / np.maximum(judged._local[1], 1e-6))[:, None, None] * own
        fitted = [
            1e3 * white.white[10:11],
            *(p.sigma * white.white[[i]] for p, i in zip(card.amplitudes, columns, strict=True)),
        ]
        every = np.concatenate([steady, WITH_TEMPERATURE * warm[s] * steady, local, *fitted]) * weight
        flat = every.reshape(len(every), -1)
        rows.append(np.concatenate([flat.real, flat.imag], axis=1))
        left = white.white[-1] + np.tensordot(judged._local[0], own, 1)
        left = (left * weight).ravel()
        residual.append(np.concatenate([left.real, left.imag]))
    design, residual = np.concatenate(rows, axis=1), np.concatenate(residual)
    _, sizes, directions = np.linalg.svd(design, full_matrices=False)
    told = sizes**2 / (1.0 + sizes**2) * (directions @ residual) ** 2
    return -0.5 * float(residual @ residual - told.sum() + np.log1p(sizes**2).sum())


def test_evidence_is_a_joint_normal_density(judged):
    """Of two effects, at the scatter that none of them leaves."""
    here = judged.here()
    names = ("stretch", "drift")
    ours = [judged.screened(name, {}, here).evidence for name in names]
    dense = [joint_density(judged, here, name) for name in names]
    assert ours[0] - ours[1] == pytest.approx(dense[0] - dense[1], abs=0.02)


@pytest.mark.parametrize("left_out", [(), ("taper",)])
def test_what_effects_have_in_common_is_integrated_once(scattered, left_out):
    context, fit = scattered(3, 0.003, 0.015)
    on = {"taper": {**context.model.cards["taper"].zero({}), "tx": 0.02}}
    linear = LinearisedSweeps.of(context.model, context.sweeps, fit.state.with_effects(on), context.executor)
    judged, alone = (RandomEffects.of(linear, context.sweeps) for _ in range(2))
    here = judged.here()
    for name in ("stretch", "drift"):
        one = judged.screened(name, {}, here, left_out)
        other = alone._inside(alone._set(left_out, (name, {})), here.modes, here.place)
        assert one.evidence == pytest.approx(other.evidence, abs=1e-6)
        assert one.values == pytest.approx(other.values, rel=1e-6)
    assert not alone._marginals


def test_the_scatter_drawn_is_found(scattered):
    found = []
    for seed in range(2, 8):
        context, fit = scattered(seed, 0.003, 0.015)
        linear = LinearisedSweeps.of(context.model, context.sweeps, fit.state, context.executor, candidates=())
        found.append(RandomEffects.of(linear, context.sweeps).here().scatter)
    assert np.sqrt(np.mean([one.frequency**2 for one in found])) == pytest.approx(0.003, rel=0.3)
    assert np.sqrt(np.mean([one.amplitude**2 for one in found])) == pytest.approx(0.015, rel=0.2)
    assert max(one.damping for one in found) < 0.001


def test_of_modes_that_scatter_no_effect_is_made(scattered):
    """Twenty sets of modes: the best of eleven effects gains three nats at most."""
    best = []
    for seed in range(20):
        context, fit = scattered(seed, 0.003, 0.015)
        linear = LinearisedSweeps.of(context.model, context.sweeps, fit.state, context.executor)
        judged = RandomEffects.of(linear, context.sweeps)
        here = judged.here()
        for name, card in context.model.cards.items():
            sites = [judged.screened(name, site, here) for site in card.sites]
            one = max(sites, key=lambda one: one.evidence)
            best.append(one.evidence - np.log(len(card.sites)) - here.evidence)
    assert max(best) < 3.0


def test_without_scatter_the_floor_is_what_is_left(scattered):
    context, fit = scattered(1, 0.0)
    linear = LinearisedSweeps.of(context.model, context.sweeps, fit.state, context.executor, candidates=())
    found = RandomEffects.of(linear, context.sweeps).here()
    half = 0.5 * float(np.exp(fit.state.laws[:, 2].mean()))
    assert found.scatter.frequency == pytest.approx(context.sweeps.twin_error * half, rel=0.3)
    assert found.place == 0


def test_an_amplitude_stays_inside_its_range(judged):
    """A mass below 0 would fit better."""
    here = judged.here()
    values = {name: judged.screened(name, {}, here).values for name in ("mass", "lag", "drift")}
    cards = judged.linear.cards
    for name, found in values.items():
        for value, parameter in zip(found, cards[name].amplitudes, strict=True):
            assert parameter.low <= value <= parameter.high
    assert min(value for found in values.values() for value in found) <= 0.0
    assert replace(here, values=()).scatter == here.scatter
