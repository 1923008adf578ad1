import numpy as np
import pytest

from analysis.focusing.fir import FirBank
from analysis.focusing.over_temperature import focus
from analysis.focusing.panel_model import covered, design_forms, reference_temperature, responses, spaced
from analysis.focusing.performance import contrast


@pytest.fixture(scope="module")
def plain(make_plate, make_panel, six):
    return make_plate(make_panel(six, transform_length=2_756, band=(100.0, 500.0), edges=(60.0, 560.0)))


@pytest.fixture(scope="module")
def focused(plain, softening):
    return focus(plain, plain.panel, softening, np.array([0.0, 20.0, 40.0, 60.0]))


def test_the_fixed_filter_is_as_good_as_any_at_its_own_temperature(focused):
    np.testing.assert_allclose(focused.fixed.contrast[1], focused.direct.contrast[1])
    np.testing.assert_allclose(focused.fixed.spot_error[1], focused.direct.spot_error[1])


def test_away_from_it_the_fixed_filter_loses_and_direct_filters_do_not(focused):
    """The finding of the paper's Fig. 13, on a plate in closed form."""
    lost = focused.direct.contrast.mean(axis=1) - focused.fixed.contrast.mean(axis=1)
    assert lost[0] > 0.05
    assert lost[3] > lost[2] > 0.1
    assert np.ptp(focused.direct.contrast.mean(axis=1)) < 0.15


def test_contrast_of_the_cut_filters_is_that_of_their_own_response(plain, softening, focused):
    material = softening.at(40.0)
    constants = [float(v[0]) for v in (material.youngs_modulus, material.poisson_ratio, material.loss_factor)]
    forms = plain.space.forms([plain.amplitudes(*constants, focused.frequency)])
    bank = FirBank(focused.bank.taps[2:3], focused.temperature[2:3], focused.bank.sample_rate, focused.bank.delay)
    exact = contrast(forms, bank.response(focused.frequency))[0]
    np.testing.assert_allclose(focused.direct.contrast[2], exact)
    uncut = contrast(forms, focused.filters[2:3][:, plain.panel.filters.in_band(focused.lines)])[0]
    np.testing.assert_allclose(focused.uncut.contrast[2], uncut)


def test_every_method_gives_filters_of_one_shape(plain, softening, focused):
    for method in ("time-reversal", "modal-control", "none"):
        other = focus(plain, plain.panel, softening, np.array([0.0, 60.0]), method)
        assert other.method == method
        assert other.filters.shape[1:] == focused.filters.shape[1:]
        assert other.direct.contrast.mean() < focused.direct.contrast.mean()


def test_rank_changes_are_counted_in_the_band_only(focused):
    band = (focused.lines >= 100.0) & (focused.lines <= 500.0)
    expected = (np.diff(focused.rank, axis=0)[:, band] != 0).sum(axis=1)
    np.testing.assert_array_equal(focused.rank_changes, expected)


def test_the_range_is_what_laws_and_panel_share(plain, softening):
    assert covered(softening, (0.0, 100.0)) == (0.0, 60.0)
    assert covered(softening, (10.0, 30.0)) == (10.0, 30.0)
    with pytest.raises(ValueError, match="nothing in common"):
        covered(softening, (60.0, 80.0))
    hot = plain.panel.filters.model_copy(update={"operating_range": (30.0, 60.0)})
    assert reference_temperature(plain.panel.model_copy(update={"filters": hot}), softening) == 30.0


@pytest.mark.parametrize(
    ("low", "high", "spacing", "expected"),
    [(0, 60, 20, [0, 20, 40, 60]), (0, 60, 25, [0, 25, 50, 60]), (5, 5.5, 0.25, [5, 5.25, 5.5])],
)
def test_spaced_temperatures_end_at_the_end(low, high, spacing, expected):
    np.testing.assert_allclose(spaced(low, high, spacing), expected)
    assert len(spaced(0.0, 60.0, 0.1)) == 601


def test_filters_robust_to_their_thermometer_keep_more_where_it_errs_and_little_is_lost_where_it_does_not(
    plain, softening
):
    """Designed at 40 °C, used from 35 to 45 °C: contrast where the thermometer errs most, and the worst line."""
    settings = plain.panel.filters
    careful = plain.panel.model_copy(update={"filters": settings.model_copy(update={"thermometer_error": 5.0})})
    lines = settings.frequency[settings.in_band(settings.frequency)]
    real = np.linspace(35.0, 45.0, 11)
    forms = plain.space.forms(amplitude for _, amplitude in responses(plain, softening, real, lines))
    reached = []
    for panel in (plain.panel, careful):
        bank = focus(plain, panel, softening, np.array([40.0])).bank
        reached.append(contrast(forms, np.repeat(bank.response(lines), 11, axis=0)))
    usual, robust = reached
    assert robust[[0, -1]].mean() > usual[[0, -1]].mean()
    assert robust.min() > usual.min()
    assert robust[5].mean() > usual[5].mean() - 0.05


@pytest.mark.parametrize(
    ("error", "here", "around"),
    [
        (5.0, 40.0, [35.0, 40.0, 45.0]),
        (2.0, 40.0, [38.0, 40.0, 42.0]),
        (8.0, 20.0, [12.0, 16.0, 20.0, 24.0, 28.0]),
        (5.0, 58.0, [53.0, 58.0, 60.0]),
    ],
)
def test_design_forms_are_the_mean_over_equal_steps_with_both_ends_within_the_laws(
    plain, softening, error, here, around
):
    panel = plain.panel.model_copy(
        update={"filters": plain.panel.filters.model_copy(update={"thermometer_error": error})}
    )
    lines, moved = panel.filters.frequency, panel.target.displacement
    alone = plain.space.forms((a for _, a in responses(plain, softening, np.array([here]), lines)), moved)
    found = design_forms(plain, panel, softening, here, alone)
    each = plain.space.forms((a for _, a in responses(plain, softening, np.array(around), lines)), moved)
    np.testing.assert_allclose(found.plate[0], each.plate.mean(axis=0))
    np.testing.assert_allclose(found.aim[0], each.aim.mean(axis=0))
    assert design_forms(plain, plain.panel, softening, here, alone) is alone
