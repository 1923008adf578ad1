"""H1 of sweeps through a known filter, its variance against repeated estimates, and bad repeats."""

import re
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import chirp, fftconvolve, lfilter, savgol_filter

from analysis.experiment import Experiment
from analysis.gap.data.noise import ROUGHNESS
from analysis.recordings.campaign import Campaign, Sweep
from analysis.recordings.frf import Frf, campaign_frf
from analysis.recordings.h1 import bad_repeats, h1, spectra
from analysis.recordings.noise_power import SMOOTHING_LINES, noise_power, single_repeat_power

RATE, SAMPLES = 8533.0, 12000
B, A = [0.2, 0.1], [1.0, -1.6, 0.9]


def recorded(rng: np.random.Generator, repeats: int = 3, noise: float = 1e-3):
    t = np.arange(SAMPLES) / RATE
    sweep = np.where(t < 1.0, chirp(t, 60.0, 1.0, 1800.0, method="logarithmic"), 0.0)
    drive = np.tile(sweep, (repeats, 1))
    clean = lfilter(B, A, drive, axis=1)
    return drive, clean + noise * rng.standard_normal(clean.shape)


def filter_response(frequency):
    z = np.exp(-2j * np.pi * frequency / RATE)
    return (B[0] + B[1] * z) / (A[0] + A[1] * z + A[2] * z**2)


def experiment() -> Experiment:
    patch = {"size": [0.02, 0.02], "thickness": 5e-4, "material": "NCE51"}
    return Experiment.model_validate(
        {
            "title": "filter",
            "plate": {"length_x": 0.24, "length_y": 0.19, "thickness": 0.003, "mass": 0.13},
            "patch": [
                {"id": "A1", "role": "actuator", "center": [0.2, 0.15], **patch},
                {"id": "S1", "role": "sensor", "center": [0.04, 0.04], **patch},
            ],
            "acquisition": {
                "module": "NI-9234", "sample_rate": RATE, "input_resistance": 3e5, "input_capacitance": 0.0
            },
            "protocol": {
                "sweep": "logarithmic", "band": [100.0, 1500.0], "sweep_duration": 1.0, "tail": 0.4, "repeats": 3,
                "ramp_rate": 0.4, "temperatures": [20.0], "directions": ["up"], "levels": [1.0],
            },
            "oven": {"room_temperature": 22.0},
        }
    )  # fmt: skip


def campaign(drive, response) -> Campaign:
    sweep = Sweep(0, "up", 1.0, 19.9, 20.1, "2026-01-01T00:00:00", drive.astype("f4"), response[None].astype("f4"))
    return Campaign("filter", experiment(), (sweep,))


def test_h1_is_the_filter_between_drive_and_response() -> None:
    drive, response = recorded(np.random.default_rng(0), noise=0.0)
    frf = campaign_frf(campaign(drive, response))
    assert frf.frequency[0] >= 100.0
    assert frf.frequency[-1] <= 1500.0
    np.testing.assert_allclose(frf.h[0, 0], filter_response(frf.frequency), rtol=2e-4)
    assert frf.temperature[0] == pytest.approx(20.0)


def test_a_tail_too_short_is_told_as_such_and_not_as_a_hum() -> None:
    """Modes of loss factor 0.2 %, a tail of 0.4 s; the leakage of this plate has peaks at multiples of 60.3 Hz."""
    rng = np.random.default_rng(17)
    count = rng.integers(6, 25)
    t = np.arange(3 * SAMPLES) / RATE
    impulse = sum(np.exp(-np.pi * f * 0.002 * t) * np.sin(2 * np.pi * f * t) for f in rng.uniform(80, 1450, count))
    drive, _ = recorded(rng, noise=0.0)
    response = fftconvolve(drive, impulse[None] / RATE * 100, axes=1)[:, :SAMPLES]
    (note,) = campaign_frf(campaign(drive, response + 1e-4 * rng.standard_normal(drive.shape))).notes
    assert "hum" not in note
    assert "S1 at 20.0 °C (1 of 1 responses) rings on" in note
    assert "it is 0.4 s: lengthen protocol.tail" in note
    loss, hertz = (float(re.search(pattern, note)[1]) for pattern in (r"factor of ([\d.]+) %", r"at (\d+) Hz"))
    needed = float(re.search(r"tail of ([\d.]+) s", note)[1])
    assert needed == pytest.approx(np.log(1000.0) / (np.pi * hertz * loss / 100), rel=0.1)
    assert 0.1 < loss < 0.4


def test_stated_variance_is_that_of_repeated_estimates() -> None:
    rng = np.random.default_rng(1)
    frfs = [campaign_frf(campaign(*recorded(rng, noise=0.02))) for _ in range(75)]
    used = ~frfs[0].excluded
    real = np.var([f.h[0, 0] for f in frfs], axis=0)[used]
    stated = np.mean([f.variance[0, 0] for f in frfs], axis=0)[used]
    ratio = np.array([part.mean() for part in np.array_split(real / stated, 10)])
    np.testing.assert_allclose(ratio, 1.0, atol=0.1)


def test_a_steady_drift_over_the_repeats_is_no_noise() -> None:
    drive, response = recorded(np.random.default_rng(7), repeats=5, noise=0.01)
    still = campaign_frf(campaign(drive, response))
    drifting = response * (1.0 + 0.05 * np.arange(-2, 3))[:, None]
    moved = campaign_frf(campaign(drive, drifting))
    np.testing.assert_allclose(moved.h, still.h, rtol=0.02, atol=2e-3)
    assert (moved.variance / still.variance).mean() == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize(("lines", "width"), [(7, 7), (8, 7), (400, 11)])
def test_roughness_is_what_a_savitzky_golay_filter_leaves(lines: int, width: int) -> None:
    h = np.random.default_rng(lines).standard_normal((lines, 2)) @ [1.0, 1.0j]
    rough = h - savgol_filter(h.real, width, 4) - 1j * savgol_filter(h.imag, width, 4)
    kept = 1.0 - savgol_filter(np.eye(width)[width // 2], width, 4)[width // 2]
    power, half = single_repeat_power(h), width // 2
    np.testing.assert_allclose(power[half:-half], (np.abs(rough) ** 2 / kept)[half:-half], rtol=1e-9)
    # the ends of savgol_filter are a quartic of the last window, as ours
    shared = (np.abs(h[:width] - savgol_ends(h, width)[:width]) ** 2).sum() / (width - 5)
    np.testing.assert_allclose(power[:half], shared, rtol=1e-9)


def savgol_ends(h: NDArray[np.complex128], width: int) -> NDArray[np.complex128]:
    """Return a quartic through the first `width` lines."""
    x = np.arange(width)
    return np.asarray(np.polyval(np.polyfit(x, h[:width], 4), x))


def test_noise_without_repeats_weighs_the_lines_at_the_ends_as_the_others() -> None:
    """Squares over the noise estimated are 1 in the mean, and 2 % more: ends were told at half of their power."""
    rng, ratio = np.random.default_rng(0), []
    everywhere = np.zeros(400, dtype=bool)
    for _ in range(400):
        h = (rng.standard_normal((400, 2)) @ [1.0, 1.0j]) / np.sqrt(2.0)
        ratio.append(np.abs(h) ** 2 / noise_power(single_repeat_power(h), np.ones(400, complex), everywhere))
    mean = np.mean(ratio, axis=0)
    assert mean[[*range(5), *range(-5, 0)]].mean() == pytest.approx(1.02, abs=0.08)
    assert mean[40:-40].mean() == pytest.approx(1.0 + ROUGHNESS / SMOOTHING_LINES, abs=0.003)


def test_variance_of_a_single_repeat_comes_from_its_roughness() -> None:
    rng = np.random.default_rng(2)
    frfs = [campaign_frf(campaign(*recorded(rng, repeats=1, noise=0.05))) for _ in range(60)]
    real = np.var([f.h[0, 0] for f in frfs], axis=0)
    stated = np.mean([f.variance[0, 0] for f in frfs], axis=0)
    assert (real / stated).mean() == pytest.approx(1.0, abs=0.15)


@pytest.mark.parametrize("at_response", [0.0, 0.05], ids=["drive alone", "drive and response"])
def test_noise_of_the_drive_counts_at_the_resonance(at_response: float) -> None:
    """Noise of a force sensor follows |H|^2; a resonance is a few lines wide, noise is averaged over more."""
    rng, sharp, frfs = np.random.default_rng(5), [1.0, -1.6, 0.996], []
    for _ in range(120):
        drive, _ = recorded(rng, repeats=4)
        response = lfilter([0.2], sharp, drive, axis=1) + at_response * rng.standard_normal(drive.shape)
        frfs.append(campaign_frf(campaign(drive + 0.01 * rng.standard_normal(drive.shape), response)))
    h = np.array([f.h[0, 0] for f in frfs])
    real, stated = h.var(0, ddof=1), np.mean([f.variance[0, 0] for f in frfs], axis=0)
    order = np.argsort(np.abs(h.mean(0)))
    for part in (order[: order.size // 4], order[-16:]):
        assert (real / stated)[part].mean() == pytest.approx(1.0, abs=0.1)


def test_coherence_falls_with_noise_as_its_definition_says() -> None:
    drive, response = recorded(np.random.default_rng(3), repeats=200, noise=0.05)
    lines = slice(200, 1800)
    h, power, coherence = (part[lines] for part in h1(drive, response))
    signal = np.abs(h) ** 2
    np.testing.assert_allclose(coherence.mean(), (signal / (signal + power)).mean(), rtol=0.01)


@pytest.mark.parametrize("repeats", [3, 4, 8])
def test_noise_of_hits_that_come_when_they_happen_to(repeats: int) -> None:
    """Three blows of different height and time, and a plate that warms up between them: the noise alone counts."""
    rng = np.random.default_rng(11)
    count, noise = 2048, 1e-3
    grid = np.fft.rfftfreq(count)
    plate = 1.0 / (1.0 - (grid / 0.1) ** 2 + 0.05j)
    stated = []
    for _ in range(40):
        at, height = rng.uniform(50.0, 150.0, repeats), rng.uniform(0.7, 1.3, repeats)
        hit = height[:, None] * np.exp(-(((np.arange(count) - at[:, None]) / 2.0) ** 2))
        warmer = 1.0 + 0.03 * (np.arange(repeats) - 0.5 * (repeats - 1))
        moved = warmer[:, None] * np.fft.irfft(plate * np.fft.rfft(hit), count)
        _, power, _ = h1(hit, moved + noise * rng.standard_normal(hit.shape))
        true = noise**2 * count * repeats / (np.abs(np.fft.rfft(hit)) ** 2).sum(0)
        stated.append((power / true)[20:400].mean())
    assert np.mean(stated) == pytest.approx(1.0, abs=0.03)


def test_a_straying_repeat_is_left_out_and_named() -> None:
    drive, response = recorded(np.random.default_rng(4))
    clean = campaign_frf(campaign(drive[[0, 2]], response[[0, 2]]))
    response[1, 4000:6000] += 0.5  # a knock on the plate
    assert bad_repeats(*(spectra(signal)[:, 140:2000] for signal in (drive, response))) == [1]
    frf = campaign_frf(campaign(drive, response))
    assert frf.notes == ("step 0: repeat 2 left out, S1 strays",)
    np.testing.assert_allclose(frf.h, clean.h)


def test_a_drive_of_nothing_at_some_line_outside_the_band_divides_nothing() -> None:
    """Samples on a grid, mean and alternating sum exactly zero: so are its lines at 0 Hz and at half the rate."""
    drive, response = recorded(np.random.default_rng(4))
    drive = np.round(drive * 2.0**16) / 2.0**16
    for first in (0, 1):  # even samples, then odd ones, to a sum of zero: the last of them lie in the tail
        drive[:, -2 + first] -= drive[:, first::2].sum(1)
    for lines in (np.fft.rfft(drive)[:, 0], np.fft.rfft(drive)[:, -1]):
        assert (lines == 0.0).all()
    h, power, coherence = h1(drive, response)
    undefined = np.zeros(h.size, dtype=bool)
    undefined[[0, -1]] = True
    for part in (h, power, coherence):
        np.testing.assert_array_equal(np.isnan(part), undefined)
    response[1, 4000:6000] += 0.5
    assert bad_repeats(*(spectra(signal)[:, 140:2000] for signal in (drive, response))) == [1]
    clean = campaign_frf(campaign(drive[[0, 2]], response[[0, 2]]))
    np.testing.assert_allclose(campaign_frf(campaign(drive, response)).h, clean.h)


def test_mains_harmonics_are_excluded() -> None:
    drive, response = recorded(np.random.default_rng(5))
    frf = campaign_frf(campaign(drive, response), mains=60.0)
    assert set(np.round(frf.frequency[frf.excluded] / 60.0)) == set(range(2, 26))


@pytest.mark.parametrize(("hum", "found"), [(49.9, True), (60.0, True), (50.0, False)])
def test_a_hum_elsewhere_than_declared_is_found_and_left_out(hum: float, found: bool) -> None:
    drive, response = recorded(np.random.default_rng(10), noise=1e-3)
    t = np.arange(SAMPLES) / RATE
    loud = response + 0.02 * sum(np.sin(2 * np.pi * hum * n * t + n) for n in range(1, 31))
    frf = campaign_frf(campaign(drive, loud))
    named = [
        float(number) for note in frf.notes for number in re.findall(r"hum at multiples of ([0-9.]+) Hz", note)
    ]
    assert named == ([pytest.approx(hum, abs=0.02)] if found else [])
    harmonics = hum * np.arange(3, 30)
    nearest = np.abs(frf.frequency[:, None] - harmonics).argmin(0)
    assert frf.excluded[nearest].all()
    assert frf.excluded.mean() < 0.2
    quiet = campaign_frf(campaign(drive, response))
    assert quiet.notes == ()


def test_frfs_that_are_not_finite_are_refused() -> None:
    drive, response = recorded(np.random.default_rng(6))
    response[0, 10] = np.nan
    with pytest.raises(ValueError, match="not finite"):
        campaign_frf(campaign(drive, response))


def test_copies_of_one_recording_are_no_repeats() -> None:
    drive, response = recorded(np.random.default_rng(8))
    campaign_frf(campaign(drive, response)).require_noise()
    copied = campaign_frf(campaign(drive, np.tile(response[:1], (3, 1))))
    with pytest.raises(ValueError, match=r"S1 at 20\.0 °C \(up\).* copies of one recording"):
        copied.require_noise()


def test_an_inverted_channel_is_turned_and_said() -> None:
    frf = campaign_frf(campaign(*recorded(np.random.default_rng(9))))
    turned = frf.turned(("S1",))
    np.testing.assert_array_equal(turned.h, -frf.h)
    assert "channel S1 is inverted: wiring, patch polarity" in turned.notes[-1]
    assert frf.turned(()) is frf


@pytest.fixture(scope="module")
def three_sweeps() -> Frf:
    h = np.ones((3, 2, 4), complex)
    return Frf(
        temperature=np.array([10.0, 20.0, 30.0]),
        direction=("up",) * 3,
        level=np.ones(3),
        frequency=np.arange(1.0, 5.0),
        h=h,
        variance=h.real,
        coherence=h.real,
        excluded=np.zeros(4, dtype=bool),
        channels=("S1", "S2"),
    )


@pytest.mark.parametrize(
    ("call", "kind", "said"),
    [
        (lambda frf: frf.without(0, "x"), TypeError, "sweeps 0: allowed is a list: each an integer"),
        (lambda frf: frf.without("a", "x"), TypeError, "sweeps 'a': allowed is a list"),
        (lambda frf: frf.without(None, "x"), TypeError, "sweeps None: allowed is a list"),
        (lambda frf: frf.without([0.0], "x"), TypeError, "sweeps 0.0: allowed is an integer"),
        (lambda frf: frf.without([True], "x"), TypeError, "sweeps True: allowed is an integer"),
        (lambda frf: frf.without([[0]], "x"), TypeError, r"sweeps \[0\]: allowed is an integer"),
        (lambda frf: frf.without([3], "x"), ValueError, "sweeps 3: 0 to 2, not all, are allowed"),
        (lambda frf: frf.without([0, 1, 2, 2], "x"), ValueError, "sweeps 0, 1, 2: 0 to 2, not all"),
        (lambda frf: frf.without([0], None), TypeError, "why None: allowed is a text"),
        (lambda frf: frf.without([0], " "), ValueError, "why '': allowed is a text that says why"),
        (
            lambda frf: frf.on(None),
            TypeError,
            "experiment None: allowed is an Experiment, the plate's declaration",
        ),
        (lambda frf: frf.on(frf), TypeError, r"experiment of type Frf: .*flexura\.load\(folder\)\.experiment"),
        (lambda frf: frf.on(experiment(), 3), TypeError, "name 3: allowed is a text"),
        (lambda frf: frf.label(2), ValueError, "channel 2: 0 to 1 allowed"),
        (lambda frf: frf.unit("S1"), TypeError, "channel 'S1': allowed is an integer"),
        (lambda frf: frf.level_unit(3), ValueError, "sweep 3: 0 to 2 allowed"),
        (lambda frf: frf.drive(None), TypeError, "sweep None: allowed is an integer"),
        (lambda frf: frf.of_source(1), ValueError, "source 1: 0 to 0 allowed"),
        (lambda frf: frf.turned("S1"), ValueError, "channels 'S1': allowed is a list: each of S1, S2"),
    ],
)
def test_arguments_of_another_kind_are_refused_in_words(
    three_sweeps: Frf, call: Callable[[Frf], object], kind: type[Exception], said: str
) -> None:
    with pytest.raises(kind, match=said):
        call(three_sweeps)


def test_a_sweep_is_left_out_once_however_it_is_named(three_sweeps: Frf) -> None:
    left = three_sweeps.without(np.array([0, 0, 2]), "wet")
    assert left.temperature.tolist() == [20.0]
    assert left.notes == tuple(f"sweep at {t} °C (up, 1 V) left out: wet" for t in ("10.0", "30.0"))
    assert three_sweeps.without([], "wet").notes == ()
