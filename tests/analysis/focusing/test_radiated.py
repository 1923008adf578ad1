"""Sound over temperature, against independent sums over the plate, and its errors against many noisy scans."""

import numpy as np
import pytest

from analysis.focusing.measured import MeasuredPanel, MeasuredTransfers
from analysis.focusing.over_temperature import focus
from analysis.focusing.panel import Filters, Panel, PanelSound, SoundListener
from analysis.focusing.panel_model import constants_at
from analysis.focusing.radiated import DEGREES, radiate, radiate_measured
from analysis.radiation.measures import far_power
from analysis.radiation.radiator import Radiator

EARS = tuple(
    SoundListener(name=name, position=(x, 0.1, 0.6), zone=name) for name, x in (("left", -0.4), ("right", 0.6))
)
TEMPERATURE = np.array([20.0, 50.0])


@pytest.fixture(scope="module")
def panel(make_panel, six):
    settings = {"taps": 128, "sample_rate": 11_025.0, "transform_length": 1_024}
    filters = Filters(band=(100.0, 500.0), edges=(60.0, 560.0), aim="listeners", zone="left", **settings)
    whole = dict(make_panel(six)) | {"filters": filters, "sound": PanelSound(listener=EARS), "grid": (20, 20)}
    return Panel(**whole)


@pytest.fixture(scope="module")
def plate(make_plate, panel):
    return make_plate(panel)


@pytest.fixture(scope="module")
def focused(plate, panel, softening):
    return focus(plate, panel, softening, TEMPERATURE)


@pytest.fixture(scope="module")
def heard(plate, panel, softening, focused):
    return radiate(plate, panel, softening, focused.bank, 20.0)


@pytest.fixture(scope="module")
def fields(plate, panel, softening, focused, heard):
    """Displacements (T, F, K) with the filters of each temperature, and with those of 20 °C."""
    both = []
    for filters in (focused.bank.response(heard.frequency), focused.bank.response(heard.frequency)[[0, 0]]):
        rows = [
            np.einsum(
                "nfr,fn,kr->fk", plate.amplitudes(*here, heard.frequency), filters[t], plate.space.deflection
            )
            for t, here in enumerate(constants_at(softening, TEMPERATURE))
        ]
        both.append(np.array(rows))
    return both


def test_pressure_power_and_direction_are_sums_over_the_plate(plate, panel, heard, fields):
    radiator = Radiator(plate.grid.points, plate.grid.area, panel.sound.air)
    places = np.array([one.position for one in EARS])
    for sound, field in zip((heard.following, heard.kept), fields, strict=True):
        for t in range(2):
            exact = np.einsum("lfk,fk->lf", radiator.pressure(places, heard.frequency), field[t])
            np.testing.assert_allclose(sound.pressure[t], exact, rtol=1e-9)
            np.testing.assert_allclose(
                sound.power[t], far_power(radiator, field[t], heard.frequency, 10), rtol=5e-3
            )
            inside = np.sum(plate.grid.area * plate.grid.target * np.abs(field[t]) ** 2, axis=1)
            whole = np.sum(plate.grid.area * np.abs(field[t]) ** 2, axis=1)
            np.testing.assert_allclose(sound.contrast[t], inside / whole, rtol=1e-9)
    sideways = np.array([[np.sin(0.5), 0.0, np.cos(0.5)], [0.0, 0.0, 1.0]])
    far = np.einsum("dfk,fk->df", radiator.far_field(sideways, heard.frequency), fields[0][1])
    member = np.abs(np.log10(heard.frequency / heard.middles[2])) < 0.05
    level = 10.0 * np.log10(np.mean(np.abs(far[0, member]) ** 2) / np.mean(np.abs(far[1, member]) ** 2))
    between = np.interp(np.rad2deg(0.5), DEGREES, heard.following.polar[1, 0, :, 2])
    assert between == pytest.approx(level, abs=0.02)


def test_shares_of_target_and_rest_add_up(plate, panel, heard, fields):
    sources = Radiator(plate.grid.points, plate.grid.area, panel.sound.air).sources(560.0)
    field = fields[0][0][..., None]
    rest = sources.power(field, heard.frequency, 1.0 - plate.grid.target)[:, 0, 0].real
    np.testing.assert_allclose(heard.following.target_share[0] + rest / heard.following.power[0], 1.0, atol=1e-9)


def test_filters_that_follow_sound_as_wanted_and_those_kept_do_not(heard, focused):
    own, kept = heard.ripple(heard.following), heard.ripple(heard.kept)
    assert own.max() < 2.0
    assert kept[0] == pytest.approx(own[0])
    assert kept[1] > 3.0
    np.testing.assert_allclose(heard.relative(heard.following)[:, 0], focused.direct.sound[:, 0], rtol=1e-9)
    zones = heard.following.zones
    assert zones.mean() > heard.kept.zones[1].mean()
    exact = 20.0 * np.log10(np.abs(heard.following.pressure[:, 0] / heard.following.pressure[:, 1]))
    assert (zones <= exact + 0.1).all()
    assert np.median(exact - zones) < 1.0
    assert (zones <= heard.zone_bound + 1e-9).all()
    assert (heard.delay_spread(heard.following) < heard.delay_spread(heard.kept) + 1e-12).all()
    peak = heard.following.peak
    np.testing.assert_allclose(peak, np.abs(focused.bank.taps).sum(axis=-1))
    rated = heard.rated_level(heard.following)
    share = (heard.limits / peak).min(axis=1)
    pascals = np.sqrt(np.mean(np.abs(heard.following.pressure[:, 0]) ** 2, axis=1) / 2.0) * share
    np.testing.assert_allclose(rated, 20.0 * np.log10(pascals / 2e-5))


def test_a_scan_without_noise_gives_the_same_sound(plate, panel, softening, focused, heard):
    measured = MeasuredPanel(panel, scan(plate, softening))
    found = radiate_measured(measured, focused.bank, 20.0)
    np.testing.assert_allclose(found.following.pressure, heard.following.pressure, rtol=1e-9)
    np.testing.assert_allclose(found.following.power, heard.following.power, rtol=1e-9)
    np.testing.assert_allclose(found.kept.target_share, heard.kept.target_share, rtol=1e-6)
    assert (found.following.pressure_sigma == 0.0).all()
    other = MeasuredTransfers(
        TEMPERATURE + 1.0,
        *(getattr(measured.transfers, name) for name in ("points", "frequency", "transfer", "variance")),
    )
    with pytest.raises(ValueError, match=r"filters of \[20.0, 50.0\] °C; the transfers were measured at \[21.0"):
        radiate_measured(MeasuredPanel(panel, other), focused.bank, 20.0)


@pytest.mark.slow
def test_the_noise_of_a_scan_makes_the_errors_that_are_stated(plate, panel, softening, focused, heard, rng):
    """Errors of pressure and power, over their stated standard deviations, have a root mean square of 1."""
    clean = scan(plate, softening)
    sigma = np.broadcast_to(
        0.05 * np.sqrt((np.abs(clean.transfer) ** 2).mean(axis=(2, 3), keepdims=True)), clean.transfer.shape
    )
    pressures, powers = [], []
    for _ in range(6):
        draws = rng.normal(size=(2, *sigma.shape)) / np.sqrt(2.0)
        noisy = MeasuredTransfers(
            clean.temperature,
            clean.points,
            clean.frequency,
            clean.transfer + sigma * (draws[0] + 1j * draws[1]),
            sigma**2,
        )
        found = radiate_measured(MeasuredPanel(panel, noisy), focused.bank, 20.0).following
        pressures.append(np.abs(found.pressure - heard.following.pressure) / found.pressure_sigma)
        powers.append((found.power - heard.following.power) / found.power_sigma)
    assert np.sqrt(np.mean(np.square(pressures))) == pytest.approx(1.0, abs=0.1)
    assert np.sqrt(np.mean(np.square(powers))) == pytest.approx(1.0, abs=0.15)
    assert np.mean(powers) == pytest.approx(0.0, abs=0.1)


def scan(plate, softening):
    lines = plate.panel.filters.frequency
    transfer = np.array(
        [
            plate.amplitudes(*here, lines) @ plate.space.deflection.T
            for here in constants_at(softening, TEMPERATURE)
        ]
    )
    return MeasuredTransfers(TEMPERATURE, plate.grid.points, lines, transfer, np.zeros(transfer.shape))
