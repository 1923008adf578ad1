"""Filters of tilted panels: exact where they were designed, followed in between, robust at a price."""

import numpy as np
import pytest

from analysis.weather.family import SIDES, FieldDesign, TiltFamily

LIMITS = (0.0, 60.0)


@pytest.fixture(scope="module")
def design(warm):
    return FieldDesign.of(warm, warm.plate.panel, 64)


@pytest.fixture(scope="module")
def family(design):
    return TiltFamily.of(design, np.arange(20.0, 41.0, 5.0), 16.0, LIMITS)


def direct(design, middle, across):
    return design.taps(design.aimed(design.amplitude(design.model.tilted(middle, across))))


@pytest.mark.parametrize("side", SIDES)
def test_at_a_knot_the_family_holds_the_filters_designed_there(design, family, side):
    across = (16.0 * side[0], 16.0 * side[1])
    exact = direct(design, 30.0, across)
    np.testing.assert_allclose(family.taps(30.0, across), exact, atol=1e-9 * np.abs(exact).max())


def test_in_between_it_loses_a_fraction_of_what_is_lost_without_the_tilt(design, family):
    middle, across = 32.5, (9.0, -5.0)
    amplitude, exact = design.amplitude(design.model.tilted(middle, across)), direct(design, middle, across)
    followed = design.lost(amplitude, exact, family.taps(middle, across))
    ignored = design.lost(amplitude, exact, family.taps(middle))
    assert followed[1] < 0.1 * ignored[1]
    assert followed[0] < 0.1 * ignored[0]


def test_robust_filters_have_the_least_mean_error_of_the_family(design, family):
    """J = r'Mr - 2 Re(a'r) over all five panels, in the band: no other of the family's filters has less."""
    fields = [design.model.tilted(30.0, (16.0 * x, 16.0 * y)) for x, y in SIDES]
    forms = [design.aimed(design.amplitude(field)) for field in fields]
    settings = design.panel.filters

    def error(taps):
        filters = design.bank(taps[None]).response(settings.frequency)[0]
        total = 0.0
        for form in forms:
            weighed = form.weighted(settings.kappa)
            moved = np.einsum("fn,fnm,fm->f", filters.conj(), weighed.damped(settings.tolerance)[0], filters).real
            aimed = np.einsum("fn,fn->f", weighed.aim[0].conj(), filters).real
            total += float(np.sum((moved - 2.0 * aimed)[design.band]))
        return total

    robust = error(family.robust_taps(30.0))
    for side in SIDES:
        assert robust < error(family.taps(30.0, (16.0 * side[0], 16.0 * side[1])))


def test_robust_filters_have_a_price(family):
    assert (family.price[:, 0] > 0.0).all()
    assert (family.price[:, 1] > family.price[:, 0]).all()


def test_beyond_the_family_its_last_filters_stay(family):
    np.testing.assert_array_equal(family.taps(30.0, (40.0, 0.0)), family.taps(30.0, (16.0, 0.0)))
    np.testing.assert_array_equal(family.taps(90.0), family.taps(40.0))


def test_near_the_end_of_the_laws_the_tilt_is_smaller(design):
    near = TiltFamily.of(design, np.array([0.0, 4.0, 30.0]), 16.0, LIMITS)
    exact = direct(design, 4.0, (8.0, 0.0))
    np.testing.assert_allclose(near.taps(4.0, (8.0, 0.0)), exact, atol=1e-9 * np.abs(exact).max())
