"""The curve between contrast and evenness, each point of it played in the time domain."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.signal import lfilter

from analysis.focusing.design import TapDesign
from analysis.focusing.panel import Filters, Panel
from analysis.focusing.pareto import EVENNESS, FAIR_RIPPLE, ParetoCurve, pareto
from analysis.focusing.played import modal_motion, sweep
from analysis.focusing.sound_aim import SoundAim
from analysis.radiation.measures import third_octave_levels

CONSTANTS = (1.2e9, 0.4, 0.06)
RATE = 11_025.0


@pytest.fixture(scope="module")
def panel(make_panel, six):
    filters = Filters(
        band=(120.0, 400.0),
        edges=(80.0, 480.0),
        aim="listeners",
        taps=256,
        sample_rate=RATE,
        transform_length=2_048,
    )
    return Panel(**dict(make_panel(six)) | {"filters": filters, "grid": (24, 20)})


@pytest.fixture(scope="module")
def curve(make_plate, panel):
    return pareto(make_plate(panel), panel, CONSTANTS, 20.0)


def test_an_even_sound_keeps_the_contrast_of_the_field(curve):
    """For one listener: evenness takes drive, not contrast; a larger weight outside gives more contrast."""
    alike = curve.outside_weight == 3.0
    assert (np.diff(curve.ripple[alike]) < 0.0).all()
    assert curve.ripple[alike][-1] < FAIR_RIPPLE < curve.ripple[alike][0]
    assert np.ptp(curve.contrast[alike]) < 0.03
    even = curve.evenness == 1.0
    assert (np.diff(curve.contrast[even]) > 0.0).all()


def test_the_front_is_what_nothing_beats_and_the_recommended_design_is_on_it(curve):
    front = curve.front
    for place in range(len(front)):
        beaten = (curve.contrast > curve.contrast[place]) & (curve.ripple < curve.ripple[place])
        assert beaten.any() <= (not front[place])
    assert front[curve.recommended]
    assert curve.ripple[curve.recommended] <= FAIR_RIPPLE
    uneven = ParetoCurve(
        20.0, *np.ones((2, 3)), np.array([0.9, 0.8, 0.7]), np.ones(3), np.array([3.0, 2.0, 4.0]), *np.ones((2, 3))
    )
    assert uneven.recommended == 1
    assert uneven.front.tolist() == [True, True, False]


@pytest.mark.slow
@pytest.mark.parametrize("place", [0, 9, 2 + 4 * (len(EVENNESS) - 1)])
def test_points_of_the_curve_are_what_a_sweep_in_the_time_domain_sounds_like(make_plate, panel, curve, place):
    """Modes integrated step by step, every element heard after its own way: no transfer function."""
    plate, settings, lines = make_plate(panel), panel.filters, panel.filters.frequency
    aim = SoundAim.of(panel, plate.grid)
    amplitude, forms = plate.amplitudes(*CONSTANTS, lines), plate.forms(*CONSTANTS, lines, 1e-6)
    asked = aim.forms(plate.space, amplitude, forms, curve.evenness[place], curve.outside_weight[place])
    design = TapDesign.of(panel, settings.middle)
    taps = design.taps(asked, np.linalg.solve(asked.plate, asked.aim[..., None])[0, ..., 0])
    signal, _ = sweep((80.0, 480.0), 2.0, RATE)
    audio = np.append(signal, np.zeros(int(0.6 * RATE)))
    drive = np.array([lfilter(one, [1.0], audio) for one in taps])
    modes = plate.modes(*CONSTANTS, count=plate.orders**2)
    motion = modal_motion(modes, drive, RATE)
    spline = CubicSpline(np.arange(len(motion)) / RATE, motion)
    ear, time = panel.listeners[0].position, np.arange(len(motion)) / RATE
    away = np.hypot(np.linalg.norm(plate.grid.points - ear[:2], axis=1), ear[2])
    heard = np.zeros(len(time))
    for way, area, shape in zip(away, plate.grid.area, plate.space.deflection, strict=True):
        late = time - way / 343.2
        acceleration = np.where(late > 0.0, spline(np.maximum(late, 0.0), 2) @ shape, 0.0)
        heard += 1.204 * area / (2.0 * np.pi * way) * acceleration
    spectrum, played = np.fft.rfft(heard), np.fft.rfft(audio.real)
    every = np.fft.rfftfreq(len(heard), 1.0 / RATE)
    band = (every >= 125.0) & (every <= 395.0)
    found = np.abs(spectrum[band] / played[band])
    response = design.bank(taps[None], np.zeros(1)).response(lines)[0]
    expected = np.abs(
        aim.relative(plate.space, amplitude, response, np.ones(len(lines), dtype=bool)) * aim.wanted
    )[0]
    ratio = found / np.interp(every[band], lines, expected)
    level = third_octave_levels(ratio, every[band])
    assert np.abs(level).max() < 0.3
