"""Networks over nodes and spacing, on filters known in closed form."""

import numpy as np
import pytest

from analysis.compensation.network import InputMap
from analysis.compensation.settings import Training
from analysis.compensation.training import study_networks
from analysis.focusing.energy import EnergyForms
from analysis.focusing.fir import FirBank


@pytest.fixture(scope="module")
def studied(tones):
    temperature = np.arange(0.0, 60.1, 1.0)
    truth = FirBank(tones(temperature), temperature, 8_000.0, 0)
    frequency, count = np.linspace(100.0, 400.0, 7), truth.taps.shape[1]
    plate = np.broadcast_to(np.eye(count, dtype=complex), (61, 7, count, count))
    target = plate * np.linspace(0.1, 0.9, count)
    forms = EnergyForms(plate, target, np.ones((61, 7, count), dtype=complex))
    inputs = InputMap.of(temperature, temperature)
    choices = [(4, 5.0), (8, 5.0), (8, 10.0), (12, 10.0)]
    return study_networks(truth, forms, frequency, choices, Training(epochs=300), inputs)


def test_every_choice_is_judged(studied):
    np.testing.assert_array_equal(studied.nodes, [4, 8, 8, 12])
    np.testing.assert_array_equal(studied.spacing, [5, 5, 10, 10])
    assert np.isfinite(studied.contrast_loss[:2]).all()
    assert np.all(studied.contrast_loss[:2] >= -1e-12)


def test_more_nodes_and_more_temperatures_come_nearer(studied):
    error = studied.squared_error.max(axis=1)
    assert error[1] < error[0]
    assert not error[2] < error[1]
