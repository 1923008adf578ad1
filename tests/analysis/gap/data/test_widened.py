"""Wider resonances: the response at a complex frequency, of recordings and of the twin alike."""

from dataclasses import replace

import numpy as np
import pytest

from analysis.gap.data.preparation import prepare
from analysis.gap.data.sweeps import cauchy_kernel, widened
from analysis.gap.fitting.normal_equations import linearise_all
from analysis.gap.fitting.state import starting_state

WIDTH, ERROR = 0.05, 0.003


def resonances(frequency):
    """Sum of some with a loss factor of 1 %, at any complex frequency."""
    return sum(1.0 / (f0**2 * (1.0 + 0.01j) - frequency**2) for f0 in (180.0, 260.0, 300.0, 510.0))


def test_the_kernel_gives_the_response_at_a_complex_frequency():
    frequency = np.geomspace(20.0, 4000.0, 20000)
    places = np.linspace(150.0, 600.0, 50)
    found = cauchy_kernel(frequency, WIDTH, places) @ resonances(frequency)
    wanted = resonances(places * (1.0 - 1j * WIDTH))
    np.testing.assert_allclose(found, wanted, atol=5e-3 * np.abs(wanted).max())  # ends are cut off


@pytest.fixture(scope="module")
def sweeps(toy):
    frf, protocol = toy.record(noise=1e-3)
    updated = toy.updated(frf)
    return prepare(frf, protocol, updated)[0], updated


def test_data_and_twin_are_widened_alike(toy, pool, sweeps):
    """At the truth they agree but for noise, of which the mean over a width leaves little."""
    sharp, updated = sweeps
    wide = widened(sharp, WIDTH, ERROR)
    state = starting_state(updated, sharp.groups)
    left = [sum(e.chi2 for e in linearise_all(toy.Plate(), one, state, [], pool)) for one in (sharp, wide)]
    assert left[1] / wide.numbers < 0.1 * left[0] / sharp.numbers


def test_a_change_of_a_share_counts_as_much_at_all_widths(sweeps):
    """It is as many standard deviations, whether neighbours at which the response is taken are many or few."""
    sharp, _ = sweeps
    one = sharp.compressed[0]
    for width in (0.02, 0.1):
        wide = widened(sharp, width, ERROR)
        there = wide.compressed[0].whitened(0.01 * one.coefficients)
        widths = np.log(sharp.nodes.frequency[-1] / sharp.nodes.frequency[0]) / width
        chi2 = (np.abs(there) ** 2).sum(axis=-1)
        np.testing.assert_allclose(chi2, widths * (0.01 / ERROR) ** 2, rtol=0.05)


def test_a_band_from_zero_has_an_end(sweeps):
    sharp, _ = sweeps
    nodes = replace(sharp.nodes, frequency=np.concatenate([[0.0], sharp.nodes.frequency[1:]]))
    assert np.isfinite(widened(replace(sharp, nodes=nodes), WIDTH, ERROR).compressed[0].kernel).all()
