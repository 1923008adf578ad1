from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

from analysis.compensation import rivals as module
from analysis.compensation.rivals import direct_filters, local_model, local_models
from analysis.focusing.methods import invert
from analysis.focusing.panel_model import constants_at
from analysis.focusing.performance import contrast

LINES = np.linspace(60.0, 600.0, 120)


@pytest.fixture(scope="module")
def wide(supported):
    """Twelve by twelve modes, most of them far above the band."""
    return replace(supported, orders=12)


def test_a_space_in_fewer_coordinates_measures_the_same_field(wide, rng):
    basis = np.linalg.qr(rng.normal(size=(144, 9)))[0]
    few = rng.normal(size=(2, 5, 9)) + 1j * rng.normal(size=(2, 5, 9))
    whole, local = wide.space.forms([few @ basis.T], 1e-6), wide.space.restricted(basis).forms([few], 1e-6)
    for name in ("plate", "target", "aim"):
        reference = getattr(whole, name)
        np.testing.assert_allclose(getattr(local, name), reference, atol=1e-12 * np.abs(reference).max())


def test_few_coordinates_answer_between_the_materials_they_are_made_from(wide):
    made_from, tried_at = (
        [(e, 0.35, 0.06) for e in (2.0e9, 2.2e9, 2.4e9)],
        [(2.1e9, 0.35, 0.06), (2.3e9, 0.35, 0.06)],
    )
    local = local_model(wide, made_from, tried_at, LINES)
    assert local.space.deflection.shape[1] < 100
    here = (2.27e9, 0.35, 0.06)
    one, other = (m.space.forms([m.amplitudes(*here, LINES)]) for m in (wide, local))
    filters = invert(one).filters
    assert np.abs(contrast(other, filters) - contrast(one, filters)).max() < 1e-3


def test_answers_that_few_coordinates_miss_are_left_to_the_whole_model(wide):
    assert local_model(wide, [(4.0e11, 0.35, 0.06)], [(5.0e8, 0.35, 0.06)], LINES) is wide


def test_a_window_of_few_temperatures_keeps_the_whole_model(wide, softening):
    temperature = np.concatenate([np.linspace(0.0, 9.9, 30), [15.0, 25.0]])
    with ThreadPoolExecutor(2) as pool:
        found = local_models(wide, lambda t: constants_at(softening, t), temperature, LINES, 0.0, pool)
    assert found[30] is wide
    assert found[31] is wide
    assert found[0] is found[29] is not wide


def test_modal_control_asks_the_whole_model_for_its_modes(wide, softening, monkeypatch):
    """They are the lowest ones, and may lie below every line at which few coordinates answer right."""
    temperature = np.linspace(20.0, 30.0, 21)
    settings = {"taps": 64, "sample_rate": 4000.0, "transform_length": 1024}
    settings |= {"band": (700.0, 900.0), "edges": (600.0, 1000.0)}
    panel = wide.panel.model_copy(update={"filters": wide.panel.filters.model_copy(update=settings)})
    local = direct_filters(wide, panel, softening, temperature, "modal-control").bank
    monkeypatch.setattr(module, "FEWEST_TEMPERATURES", 1000)
    whole = direct_filters(wide, panel, softening, temperature, "modal-control").bank
    np.testing.assert_allclose(local.taps, whole.taps, atol=1e-3 * np.abs(whole.taps).max())


def test_filters_of_local_models_are_those_of_the_whole(wide, softening, monkeypatch):
    temperature = np.linspace(20.0, 30.0, 21)
    small = wide.panel.filters.model_copy(update={"taps": 64, "sample_rate": 4000.0, "transform_length": 1024})
    panel = wide.panel.model_copy(update={"filters": small})
    local = direct_filters(wide, panel, softening, temperature)
    monkeypatch.setattr(module, "FEWEST_TEMPERATURES", 1000)
    whole = direct_filters(wide, panel, softening, temperature)
    assert local.models[0] is local.models[-1] is not whole.models[0] is wide
    assert np.abs(local.bank.taps - whole.bank.taps).max() > 0.0
    lines = small.frequency[small.in_band(small.frequency)]
    reached, response = contrast(whole.forms, whole.bank.response(lines)), local.bank.response(lines)
    np.testing.assert_allclose(contrast(whole.forms, response), reached, atol=1e-4)
    np.testing.assert_allclose(contrast(local.forms, response), reached, atol=1e-3)
