"""Nothing is lost: chi2, gradient and noise are those of all lines."""

import numpy as np
import pytest

from analysis.gap.data.compression import Nodes, compress
from analysis.gap.thresholds import NODES_PER_HALF_WIDTH


def lines(spacing=0.5):
    frequency = np.arange(100.0, 1500.0, spacing)
    return frequency[np.abs(frequency - 50.0 * np.round(frequency / 50.0)) >= 1.5 * spacing]


def resonance(frequency, at=700.0, loss=0.04):
    return at**2 * loss / (at**2 * (1.0 + 1j * loss) - frequency**2)


def measured(frequency, clean, rng):
    variance = 1e-4 * (300.0 / frequency) * np.ones(clean.shape)
    error = rng.standard_normal(clean.shape) + 1j * rng.standard_normal(clean.shape)
    return clean + np.sqrt(variance / 2.0) * error, variance


@pytest.mark.parametrize("at", [130.0, 444.0, 1210.0])
def test_splines_through_the_nodes_follow_the_sharpest_resonance(at):
    frequency = lines(0.25)
    nodes = Nodes.over(frequency, 0.04, spacing=0.25)
    through = nodes.at_lines(nodes.coefficients(resonance(nodes.frequency, at)[None]))
    assert nodes.frequency.size < 0.2 * frequency.size
    assert np.abs(through - resonance(frequency, at)).max() < 3e-4  # of a peak of 1


def test_spline_error_falls_with_the_sixth_power_of_the_spacing():
    frequency = lines(0.1)
    errors = []
    for per_half_width in (NODES_PER_HALF_WIDTH, 1.5 * NODES_PER_HALF_WIDTH):
        nodes = Nodes.over(frequency, 0.04, spacing=0.1, per_half_width=per_half_width)
        through = nodes.at_lines(nodes.coefficients(resonance(nodes.frequency)[None]))
        errors.append(np.abs(through - resonance(frequency)).max())
    assert np.log(errors[0] / errors[1]) / np.log(1.5) > 5.0


def test_chi2_and_its_gradient_are_those_of_all_lines():
    rng = np.random.default_rng(3)
    frequency = lines()
    nodes = Nodes.over(frequency, 0.036, spacing=0.5)
    h, variance = measured(frequency, np.array([resonance(frequency), resonance(frequency, 300.0)]), rng)
    sweep = compress(h, variance, nodes)

    def model(f, shift):
        return np.array([resonance(f, 700.0 + shift), resonance(f, 300.0 + shift)])

    def full(shift):
        return 2.0 * (np.abs(h - model(frequency, shift)) ** 2 / variance).sum()

    def few(shift):
        residual = sweep.coefficients - nodes.coefficients(model(nodes.frequency, shift))
        return sweep.chi2_within.sum() + (np.abs(sweep.whitened(residual)) ** 2).sum()

    assert few(0.0) == pytest.approx(full(0.0), rel=1e-4)
    assert few(0.7) == pytest.approx(full(0.7), rel=1e-4)
    # the slope that a fit follows, at a place where the misfit is noise alone
    assert (few(0.01) - few(-0.01)) == pytest.approx(full(0.01) - full(-0.01), rel=1e-2)


@pytest.mark.parametrize("loss", [0.002, 0.006, 0.015])
def test_resonances_sharper_than_nodes_can_be_keep_their_chi2(loss):
    """Sheet metals: a resonance of half a hertz in a record of two seconds; each line is a node there."""
    rng = np.random.default_rng(7)
    frequency = lines()
    nodes = Nodes.over(frequency, 0.9 * loss, spacing=0.5)
    peaks = [(160.0, 1.0), (420.0, 0.7), (1210.0, 0.5)]

    def model(f, shift):
        return sum(size * resonance(f, at * (1.0 + shift), loss) for at, size in peaks)[None]

    h, variance = measured(frequency, model(frequency, 0.0), rng)
    sweep = compress(h, variance, nodes)
    for shift in (0.0, 0.02 * loss):
        residual = sweep.coefficients - nodes.coefficients(model(nodes.frequency, shift))
        few = sweep.chi2_within.sum() + (np.abs(sweep.whitened(residual)) ** 2).sum()
        assert few == pytest.approx(2.0 * (np.abs(h - model(frequency, shift)) ** 2 / variance).sum(), rel=1e-3)


def test_noise_becomes_white_with_unit_variance():
    rng = np.random.default_rng(4)
    frequency = lines()
    nodes = Nodes.over(frequency, 0.04, spacing=0.5)
    total, count, neighbours, within, freedom = 0.0, 0, 0.0, 0.0, 0
    for _ in range(40):
        h, variance = measured(frequency, np.zeros((1, frequency.size), dtype=complex), rng)
        sweep = compress(h, variance, nodes)
        white = sweep.whitened(sweep.coefficients)
        total += (np.abs(white) ** 2).sum()
        neighbours += (white[:, 1:] * white[:, :-1].conj()).real.sum()
        count += 2 * white.size
        within += sweep.chi2_within.sum()
        freedom += sweep.dof_within
    assert abs(total / count - 1.0) < 4.0 * np.sqrt(2.0 / count)
    assert abs(neighbours) < 4.0 * np.sqrt(count)
    assert abs(within / freedom - 1.0) < 4.0 * np.sqrt(2.0 / freedom)


def test_a_blocks_share_of_the_freedom_is_right():
    rng = np.random.default_rng(5)
    frequency = lines()
    nodes = Nodes.over(frequency, 0.04, spacing=0.5)
    blocks = [
        compress(*measured(frequency, np.zeros((1, frequency.size), dtype=complex), rng), nodes).chi2_within
        for _ in range(60)
    ]
    freedom = compress(*measured(frequency, np.zeros((1, frequency.size), dtype=complex), rng), nodes).block_dof
    mean = np.mean(blocks, axis=0)[0]
    assert np.abs(mean / freedom - 1.0).max() < 6.0 * np.sqrt(2.0 / (60 * freedom.min()))
    assert freedom.sum() == pytest.approx(2 * (frequency.size - nodes.frequency.size))


@pytest.mark.parametrize("spacing", [0.5, 0.7934])
def test_no_node_is_nearer_to_another_than_lines_are(spacing):
    """Low resonances take every line for a node; where nodes begin to spread, two of them nearly met.

    The noise was then counted over too many degrees of freedom: 12 % too quiet at a loss factor of 0.0436.
    """
    frequency, rng = lines(spacing), np.random.default_rng(0)
    noise = measured(frequency, np.zeros((1, frequency.size), dtype=complex), rng)
    for loss in np.linspace(0.035, 0.06, 200):
        nodes = Nodes.over(frequency, loss, spacing=spacing)
        assert np.diff(nodes.frequency).min() > 0.999 * spacing
        sweep = compress(*noise, nodes)
        assert sweep.block_dof.sum() == pytest.approx(sweep.dof_within, rel=1e-6)


def test_rescaling_is_measuring_with_another_variance():
    rng = np.random.default_rng(6)
    frequency = lines()
    nodes = Nodes.over(frequency, 0.04, spacing=0.5)
    h, variance = measured(frequency, resonance(frequency)[None], rng)
    once, again = compress(h, 2.5 * variance, nodes), compress(h, variance, nodes).rescaled(np.array([2.5]))
    assert again.factor == pytest.approx(once.factor)
    assert again.chi2_within == pytest.approx(once.chi2_within)


def test_too_few_lines_for_a_sharp_resonance_are_refused():
    with pytest.raises(ValueError, match="cannot carry"):
        Nodes.over(np.linspace(100.0, 120.0, 8), 0.0001, spacing=0.01)
    frequency = np.concatenate([np.arange(100.0, 500.0), np.arange(900.0, 1500.0)])
    nodes = Nodes.over(frequency, 0.02, spacing=1.0)
    with pytest.raises(ValueError, match="too few usable lines"):
        compress(np.ones((1, frequency.size), dtype=complex), np.ones((1, frequency.size)), nodes)
