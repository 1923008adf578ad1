"""The band of contrast that uncertain laws leave, against plates drawn and computed one by one."""

from dataclasses import replace

import numpy as np
import pytest

from analysis.compensation.law_band import DRAWS, law_band
from analysis.compensation.rivals import local_model
from analysis.focusing.over_temperature import focus
from analysis.focusing.panel_model import constants_at
from analysis.focusing.performance import contrast

SPREAD = (0.02, 0.01, 0.1)
"""Of log E, nu and log eta, at every temperature."""


def certain(laws, *spread):
    """Laws whose standard deviations are `spread` at all temperatures: all coefficients of a law err alike."""
    count = laws.coefficients.shape[1]
    return replace(laws, covariance=np.array([s**2 * np.ones((count, count)) for s in spread]))


@pytest.fixture(scope="module")
def plain(make_plate, make_panel, six):
    settings = {"taps": 128, "sample_rate": 11_025.0, "delay": 64, "transform_length": 1_024}
    return make_plate(make_panel(six, band=(100.0, 500.0), edges=(60.0, 560.0), **settings))


@pytest.fixture(scope="module")
def bank(plain, softening):
    return focus(plain, plain.panel, softening, np.array([10.0, 40.0])).bank


def computed(plain, laws, bank, spread, count, rng):
    """Contrast (count, A, F) of plates drawn, each of them computed."""
    lines = plain.panel.filters.frequency
    lines = lines[plain.panel.filters.in_band(lines)]
    response, material = bank.response(lines), laws.at(bank.temperature)
    found = []
    for draw in rng.standard_normal((count, 3)) * spread:
        row = []
        for t in range(len(bank.temperature)):
            e = material.youngs_modulus[t] * np.exp(draw[0])
            nu, eta = material.poisson_ratio[t] + draw[1], material.loss_factor[t] * np.exp(draw[2])
            forms = plain.space.forms([plain.amplitudes(e, nu, eta, lines)])
            row.append(contrast(forms, response[t : t + 1])[0])
        found.append(row)
    return np.array(found)


@pytest.mark.slow
def test_the_band_holds_nine_of_ten_plates_drawn_and_computed(plain, softening, bank, rng):
    laws = certain(softening, *SPREAD)
    found = law_band([plain, plain], plain.panel, laws, bank, rng)
    drawn = computed(plain, laws, bank, np.array(SPREAD), 400, rng)
    assert found.draws == DRAWS
    for band, values in ((found.mean, drawn.mean(axis=2)), (found.worst, drawn.min(axis=2))):
        inside = (values >= band[:, 0]) & (values <= band[:, 1])
        assert inside.mean() == pytest.approx(found.share, abs=0.04)  # 1.5 % of 400 draws, and of the band's own
        exact = np.quantile(values, [0.05, 0.95], axis=0).T
        np.testing.assert_allclose(band, exact, atol=0.1 * np.ptp(exact, axis=1).max())


def test_one_uncertain_modulus_is_followed_along_its_own_line(plain, softening, bank, rng):
    """With E alone uncertain, and a contrast that falls to both sides, plates at its quantiles give the ends."""
    laws = certain(softening, 0.005, 0.0, 0.0)
    found = law_band([plain, plain], plain.panel, laws, bank, rng)
    grid = 0.005 * np.linspace(-3.0, 3.0, 61)
    drawn = np.array([computed_at(plain, laws, bank, step) for step in grid])
    weight = np.exp(-0.5 * (grid / 0.005) ** 2)
    for t in range(2):
        order = np.argsort(drawn[:, t])
        share = np.cumsum(weight[order]) / weight.sum()
        exact = np.interp([0.05, 0.95], share, drawn[order, t])
        np.testing.assert_allclose(found.mean[t], exact, atol=0.1 * np.ptp(exact) + 1e-5)


def test_the_coordinates_of_a_few_kelvins_give_the_band_of_the_whole_panel(plain, softening, bank):
    """Also where plates drawn are off the law that the coordinates were made along."""
    wide, laws = replace(plain, orders=12), certain(softening, *SPREAD)
    made = [constants_at(softening, np.array([t - 5.0, t, t + 5.0])) for t in bank.temperature]
    lines = plain.panel.filters.frequency
    local = [local_model(wide, one, one[1:2], lines) for one in made]
    assert all(one.space.deflection.shape[1] < 100 for one in local)
    seeds = [np.random.default_rng(3) for _ in range(2)]
    found, exact = (
        law_band(m, plain.panel, laws, bank, r) for m, r in zip((local, [wide] * 2), seeds, strict=True)
    )
    for name in ("nominal", "mean", "worst"):
        np.testing.assert_allclose(getattr(found, name), getattr(exact, name), atol=1e-4)


def computed_at(plain, laws, bank, step):
    rng = type("Fixed", (), {"standard_normal": lambda self, shape: np.array([[step, 0.0, 0.0]])})()
    return computed(plain, laws, bank, 1.0, 1, rng)[0].mean(axis=1)


def test_certain_laws_leave_no_band(plain, softening, bank, rng):
    found = law_band([plain, plain], plain.panel, softening, bank, rng)
    np.testing.assert_allclose(found.mean, found.nominal[:, [0, 0]])
    np.testing.assert_allclose(found.worst, found.nominal[:, [1, 1]])
    focused = focus(plain, plain.panel, softening, bank.temperature)
    np.testing.assert_allclose(found.nominal[:, 0], focused.direct.contrast.mean(axis=1))
    np.testing.assert_allclose(found.nominal[:, 1], focused.direct.contrast.min(axis=1))


def test_a_law_at_the_edge_of_the_twin_s_box_is_judged_from_inside(plain, softening, bank, rng):
    """The model answers inside its box only: the parabola stands on what lies there."""
    laws = certain(softening, *SPREAD)
    e = float(softening.at(bank.temperature[:1]).youngs_modulus[0])
    twin = plain.panel.twin.model_copy(update={"youngs_modulus": (0.5 * e, e)})
    panel = plain.panel.model_copy(update={"twin": twin})
    asked = []

    class Watched:
        space = plain.space

        def forms(self, *constants):
            asked.append(constants[0])
            return plain.forms(*constants)

    found = law_band(
        [Watched()], panel, laws, replace(bank, taps=bank.taps[:1], temperature=bank.temperature[:1]), rng
    )
    assert max(asked) <= e * (1.0 + 1e-9)
    assert found.outside == pytest.approx([0.5], abs=0.05)  # the stiffer half of the draws
    assert found.mean[0, 0] < found.nominal[0, 0] < found.mean[0, 1]
