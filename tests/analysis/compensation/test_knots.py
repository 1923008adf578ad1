"""Training temperatures placed where filters change, beside equidistant ones."""

import numpy as np
import pytest

from analysis.compensation.knots import place_temperatures
from analysis.compensation.rivals import cubic_spline
from analysis.focusing.energy import EnergyForms
from analysis.focusing.fir import FirBank
from analysis.focusing.performance import contrast

LINES = np.arange(150.0, 500.0, 10.0)
EVERYWHERE = np.arange(0.0, 60.1, 0.5)


def known(tones, law):
    """Make filters that follow law(T), and forms in which their own direction is the target."""
    bank = FirBank(tones(law(EVERYWHERE)), EVERYWHERE, 8_000.0, 16)
    response = bank.response(LINES)
    aim = response.conj() / np.linalg.norm(response, axis=-1, keepdims=True)
    plate = np.broadcast_to(np.eye(2), (*aim.shape, 2)).astype(complex)
    return bank, EnergyForms(plate, aim[..., :, None].conj() * aim[..., None, :], aim)


def lost(bank, forms, temperature):
    """Contrast that a spline through the filters at `temperature` loses at the worst line."""
    rows = np.searchsorted(bank.temperature, temperature)
    few = FirBank(bank.taps[rows], bank.temperature[rows], bank.sample_rate, bank.delay)
    taps = cubic_spline(few, few.temperature, bank.temperature)
    response = FirBank(taps, bank.temperature, bank.sample_rate, bank.delay).response(LINES)
    return float((contrast(forms, bank.response(LINES)) - contrast(forms, response)).max())


@pytest.mark.parametrize("count", [8, 11])
def test_filters_that_change_in_a_part_of_the_range_are_trained_there(tones, count):
    """A glass transition at 15 °C: pitch falls within 16 °C, and hardly elsewhere."""
    bank, forms = known(tones, lambda t: 30.0 + 20.0 * np.tanh((t - 15.0) / 8.0))
    found = place_temperatures(bank, forms, LINES, count)
    assert len(found.temperature) == count
    assert (found.temperature[0], found.temperature[-1]) == (0.0, 60.0)
    assert (np.diff(found.temperature) > 0.0).all()
    near = np.abs(found.temperature - 15.0) < 15.0
    assert near.sum() > (np.abs(found.equidistant - 15.0) < 15.0).sum()
    assert found.loss < 0.5 * found.equidistant_loss
    assert found.loss == pytest.approx(lost(bank, forms, found.temperature), rel=1e-6)
    assert found.equidistant_loss == pytest.approx(lost(bank, forms, found.equidistant), rel=1e-6)


def test_placing_never_loses_against_equal_steps(tones):
    bank, forms = known(tones, lambda t: t)
    found = place_temperatures(bank, forms, LINES, 13)
    assert found.loss <= found.equidistant_loss


def test_too_few_and_too_many_are_refused(tones):
    bank, forms = known(tones, lambda t: t)
    for count in (3, 62):
        with pytest.raises(ValueError, match=f"{count} training temperatures; allowed 4 to 61, 0 to 60 °C"):
            place_temperatures(bank, forms, LINES, count)
