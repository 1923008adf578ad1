import numpy as np
import pytest

from analysis.focusing.fir import FirBank, energy, inverse_fft, suited_delay, taper
from analysis.focusing.panel import Filters

SETTINGS = Filters(
    taps=256, sample_rate=8_000.0, transform_length=4_096, delay=128, band=(300.0, 1_200.0), edges=(100.0, 1_500.0)
)

UP_TO_NYQUIST = SETTINGS.model_copy(update={"band": (300.0, 3_999.0), "edges": (100.0, 3_999.0)})
"""To line 2047 of 2048."""


def spread(spectrum):
    return np.asarray(spectrum, dtype=complex)[None, :, None]


def test_the_taper_is_one_in_the_band_half_midway_and_zero_outside():
    frequency = np.array([0.0, 99.0, 100.0, 200.0, 300.0, 700.0, 1_200.0, 1_350.0, 1_500.0, 1_600.0])
    gain = taper(frequency, SETTINGS)
    np.testing.assert_allclose(gain, [0, 0, 0, 0.5, 1, 1, 1, 0.5, 0, 0], atol=1e-15)


def test_a_band_without_edges_ends_with_full_gain():
    sharp = SETTINGS.model_copy(update={"edges": SETTINGS.band})
    np.testing.assert_array_equal(taper(np.array([299.9, 300.0, 1_200.0, 1_200.1]), sharp), [0, 1, 1, 0])


def test_a_pure_delay_becomes_the_tapered_band_pulse_at_its_time():
    """R = exp(-jωτ): the peak stands at delay + τ fs, and moves with τ sample by sample."""
    frequency = SETTINGS.frequency
    for shift in (-40, 0, 25):
        bank = inverse_fft(spread(np.exp(-2j * np.pi * frequency * shift / 8_000.0)), np.zeros(1), SETTINGS, 128)
        assert np.argmax(bank.taps[0, 0]) == 128 + shift


def test_taps_are_those_of_the_full_inverse_transform(rng):
    frequency = SETTINGS.frequency
    filters = rng.normal(size=(2, len(frequency), 3)) + 1j * rng.normal(size=(2, len(frequency), 3))
    bank = inverse_fft(filters, np.array([0.0, 5.0]), SETTINGS, 128)
    lines = np.round(frequency * 4_096 / 8_000.0).astype(int)
    full = np.zeros((2, 3, 2_049), dtype=complex)
    delayed = filters * (taper(frequency, SETTINGS) * np.exp(-2j * np.pi * frequency * 128 / 8_000.0))[:, None]
    full[..., lines] = delayed.transpose(0, 2, 1)
    np.testing.assert_allclose(bank.taps, np.fft.irfft(full, 4_096)[..., :256], atol=1e-14)


def test_the_response_of_a_filter_that_fits_its_taps_is_the_one_asked_for():
    frequency = SETTINGS.frequency
    asked = 2.0 * np.exp(-2j * np.pi * frequency * 20 / 8_000.0)
    bank = inverse_fft(spread(asked), np.zeros(1), SETTINGS, 128)
    got = bank.response(frequency)[0, :, 0]
    np.testing.assert_allclose(got, asked * taper(frequency, SETTINGS), atol=5e-3)


def test_the_response_is_the_transform_of_the_taps():
    taps = np.zeros((1, 1, 64))
    taps[0, 0, [10, 12]] = 1.0, -0.5
    bank = FirBank(taps, np.zeros(1), 1_000.0, 10)
    frequency = np.array([0.0, 100.0, 250.0])
    exact = 1.0 - 0.5 * np.exp(-2j * np.pi * frequency * 2 / 1_000.0)
    np.testing.assert_allclose(bank.response(frequency)[0, :, 0], exact, atol=1e-14)


@pytest.mark.parametrize("settings", [SETTINGS, UP_TO_NYQUIST], ids=["narrow", "up to Nyquist"])
def test_energies_obey_parseval(rng, settings):
    frequency = settings.frequency
    filters = rng.normal(size=(1, len(frequency), 2)) + 1j * rng.normal(size=(1, len(frequency), 2))
    shares = energy(filters, settings, 128)
    np.testing.assert_allclose(shares.before + shares.inside + shares.after, 1.0)
    spectrum = np.abs(filters[0] * taper(frequency, settings)[:, None]) ** 2
    whole = 2.0 / 4_096 * spectrum.sum(axis=0)
    bank = inverse_fft(filters, np.zeros(1), settings, 128)
    np.testing.assert_allclose(shares.inside[0], (bank.taps[0] ** 2).sum(axis=-1) / whole, rtol=1e-10)
    np.testing.assert_allclose(
        shares.pre_ringing[0], (bank.taps[0, :, :128] ** 2).sum(axis=-1) / whole, rtol=1e-10
    )


def test_early_and_late_sound_are_told_apart():
    frequency = SETTINGS.frequency

    def shares(shift):
        found = energy(spread(np.exp(-2j * np.pi * frequency * shift / 8_000.0)), SETTINGS, 128)
        return found.before.item(), found.inside.item(), found.after.item()

    assert shares(-400)[0] > 0.99
    assert shares(0)[1] > 0.99
    assert shares(400)[2] > 0.99


def test_wrong_shapes_are_refused():
    with pytest.raises(ValueError, match="lines of the settings"):
        inverse_fft(np.ones((1, 5, 2), dtype=complex), np.zeros(1), SETTINGS, 128)
    with pytest.raises(ValueError, match=r"\(T, N, M\)"):
        FirBank(np.zeros((2, 1, 8)), np.zeros(1), 1.0, 0)
    with pytest.raises(ValueError, match="outside the 8 taps"):
        FirBank(np.zeros((1, 1, 8)), np.zeros(1), 1.0, 8)


@pytest.mark.parametrize("shift", [-90, -20, 0, 60])
def test_the_suited_delay_puts_the_most_energy_inside_the_taps(shift):
    """Against all delays tried: the share inside the taps is largest there, or as large as anywhere."""
    frequency = SETTINGS.frequency
    ringing = np.exp(-2j * np.pi * frequency * shift / 8_000.0) / (1.0 + 1j * (frequency - 700.0) / 9.0)
    filters = np.stack([spread(ringing)[..., 0], spread(np.conj(ringing))[..., 0] * 0.1], axis=-1)
    found = suited_delay(filters, SETTINGS)
    delays = [*range(0, 256, 8), found]
    held = [np.square(inverse_fft(filters, np.zeros(1), SETTINGS, d).taps).sum() for d in delays]
    assert held[-1] == pytest.approx(max(held))


def test_time_reversal_wants_its_delay_late():
    """The conjugate of a causal ringing answers before its time: nearly all taps have to come before zero."""
    ringing = 1.0 / (1.0 + 1j * (SETTINGS.frequency - 700.0) / 15.0)
    assert suited_delay(spread(ringing), SETTINGS) < 40
    assert suited_delay(spread(ringing.conj()), SETTINGS) > 216
