"""Compensation from measured transfers, beside that of the model they were taken from."""

import numpy as np
import pytest

from analysis.compensation.rivals import cubic_spline
from analysis.compensation.settings import Training, suited_nodes
from analysis.compensation.study import compensate, compensate_measured
from analysis.compensation.training import left_out_taps
from analysis.focusing.measured import MeasuredPanel, MeasuredTransfers
from analysis.focusing.over_temperature import focus

TEMPERATURES = np.arange(0.0, 61.0, 5.0)


@pytest.fixture(scope="module")
def plain(make_plate, make_panel, six):
    """Lay out a panel whose cells are those of the scan."""
    settings = {"taps": 128, "sample_rate": 11_025.0, "delay": 64, "transform_length": 1_024}
    panel = make_panel(six, band=(100.0, 500.0), edges=(60.0, 560.0), **settings)
    return make_plate(panel.model_copy(update={"grid": (12, 10)}))


def scanned(plain, laws, temperatures):
    frequency, material = plain.panel.filters.frequency, laws.at(temperatures)
    rows = zip(material.youngs_modulus, material.poisson_ratio, material.loss_factor, strict=True)
    fields = np.array([plain.amplitudes(*map(float, row), frequency) @ plain.space.deflection.T for row in rows])
    return MeasuredTransfers(temperatures, plain.grid.points, frequency, fields, np.zeros(fields.shape))


@pytest.fixture(scope="module")
def measured(plain, softening):
    return MeasuredPanel(plain.panel, scanned(plain, softening, TEMPERATURES))


@pytest.fixture(scope="module")
def found(measured):
    return compensate_measured(measured, Training(nodes=suited_nodes(13, measured=True)), lambda: 0.0)


def test_the_networks_are_those_of_the_model_the_transfers_come_from(plain, softening, found):
    """Filters, and what is trained on them: nothing is lost on the way through transfers."""
    twin = compensate(
        plain,
        plain.panel,
        softening,
        5.0,
        Training(feed="temperature", nodes=suited_nodes(13, measured=True)),
        lambda: 0.0,
        step=5.0,
    )
    largest = np.abs(twin.filters.taps).max()
    np.testing.assert_allclose(found.filters.taps, twin.filters.taps, atol=0.01 * largest)  # areas are sampled
    own, other = (one.trained.networks.taps(TEMPERATURES) for one in (found, twin))
    np.testing.assert_allclose(own, other, atol=0.01 * largest)
    np.testing.assert_allclose(found.contrast_direct, twin.contrast_direct[1:-1], atol=2e-3)


def test_each_inner_temperature_is_judged_by_what_is_made_without_it(plain, softening, measured, found):
    assert found.judged == "left-out"
    assert found.methods == ("network", "linear", "cubic-spline", "low-rank")
    np.testing.assert_array_equal(found.temperature, TEMPERATURES[1:-1])
    np.testing.assert_array_equal(found.training_temperature, TEMPERATURES)
    without = left_out_taps(found.filters, lambda bank, at: cubic_spline(bank, bank.temperature, at))
    truth = focus(plain, plain.panel, softening, TEMPERATURES[1:-1]).direct.contrast
    np.testing.assert_allclose(found.contrast_direct, truth, atol=2e-3)
    spline = found.methods.index("cubic-spline")
    energy = ((without - found.filters.taps[1:-1]) ** 2).sum(axis=-1) / (found.filters.taps[1:-1] ** 2).sum(-1)
    np.testing.assert_allclose(found.relative_error[spline], 100.0 * energy)
    assert found.largest_loss[spline] < found.largest_loss[found.methods.index("linear")]
    assert found.trained.settings.nodes == 8
    assert found.largest_loss[0] < 0.02


def test_few_temperatures_are_refused(plain, softening):
    few = MeasuredPanel(plain.panel, scanned(plain, softening, TEMPERATURES[:4]))
    with pytest.raises(ValueError, match="transfers at 4 temperatures; at least 5 are needed"):
        compensate_measured(few, Training(), lambda: 0.0)


@pytest.mark.parametrize("count", range(4, 41))
def test_few_temperatures_get_fewer_nodes_than_there_are_filters(count):
    placed, measured = suited_nodes(count), suited_nodes(count, measured=True)
    assert 2 * placed + 512 * (placed + 1) < 512 * count  # fewer weights than errors, of 512 taps
    assert measured < count
    assert max(placed, measured) <= Training().nodes
    assert suited_nodes(100) == Training().nodes
