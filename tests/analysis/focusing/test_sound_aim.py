"""Filters chosen by sound, on a plate in closed form: what they are to do, and what they may not cost."""

import numpy as np
import pytest
from pydantic import ValidationError

from analysis.focusing.design import peak_drive
from analysis.focusing.over_temperature import focus
from analysis.focusing.panel import Filters, Panel, PanelSound, SoundListener
from analysis.focusing.sound_aim import SoundAim
from analysis.radiation.measures import ripple

SETTINGS = {"transform_length": 2_756, "band": (100.0, 500.0), "edges": (60.0, 560.0)}
CONSTANTS = (1.8e9, 0.36, 0.07)


def panel_with(make_panel, six, sound=None, **filters):
    bare = make_panel(six)
    return Panel(**dict(bare) | {"filters": Filters(**SETTINGS | filters), "sound": sound or PanelSound()})


def designed(plate, panel, constants=CONSTANTS):
    """Forms of the field and of the sound, amplitudes, and the filters of the sound (F, N)."""
    lines = panel.filters.frequency
    amplitude = plate.amplitudes(*constants, lines)
    forms = plate.space.forms([amplitude], panel.target.displacement)
    sound = SoundAim.of(panel, plate.grid)
    asked = sound.forms(plate.space, amplitude, forms)
    filters = np.linalg.solve(asked.damped(0.01), asked.aim[..., None])[0, ..., 0]
    return sound, amplitude, forms, filters


def test_what_is_wanted_is_the_sound_of_the_target_moving_alone(make_panel, make_plate, six):
    sound = PanelSound(curve=((100.0, 0.0), (200.0, -6.0), (400.0, 3.0)), level=-4.0)
    panel = panel_with(make_panel, six, sound, aim="listeners")
    plate = make_plate(panel)
    aimed, lines = SoundAim.of(panel, plate.grid), panel.filters.frequency
    area, place = plate.grid.area @ plate.grid.target, panel.target_center
    away = np.hypot(np.hypot(place[0] - 0.12, place[1] - 0.095), 1.0)
    omega, k = 2.0 * np.pi * lines, 2.0 * np.pi * lines / 343.2
    point = -(omega**2) * 1.204 * 1e-6 * area * np.exp(-1j * k * away) / (2.0 * np.pi * away)
    level = 20.0 * np.log10(np.abs(aimed.wanted[0] / point))
    octaves = np.log2(lines / 100.0)
    drawn = np.select(
        [octaves < 0.0, octaves < 1.0, octaves < 2.0], [0.0, -6.0 * octaves, -6.0 + 9.0 * (octaves - 1)], 3.0
    )
    np.testing.assert_allclose(level, drawn - 4.0, atol=0.01)
    assert np.abs(np.angle(aimed.wanted[0] / point)).max() < 0.05


@pytest.mark.parametrize("aim", ["listeners", "volume"])
def test_one_listener_hears_what_is_wanted_and_no_contrast_is_lost(make_panel, make_plate, six, softening, aim):
    panel = panel_with(make_panel, six, aim=aim, taps=512)
    plate = make_plate(panel)
    temperature = np.array([0.0, 20.0, 60.0])
    by_field = focus(plate, panel_with(make_panel, six, taps=512), softening, temperature)
    by_sound = focus(plate, panel, softening, temperature)
    assert by_field.direct.sound is None
    loss = by_field.direct.contrast.mean(axis=1) - by_sound.direct.contrast.mean(axis=1)
    assert loss.max() < 0.02
    heard = by_sound.direct.sound[:, 0]
    assert ripple(heard, by_sound.frequency).max() < 0.5
    assert np.abs(np.angle(heard)).max() < 0.2  # the phase is that of the wanted sound, too
    # a judge who only listens hears that the field's own filters are uneven
    judged = focus(
        plate, panel_with(make_panel, six, PanelSound(listener=panel.listeners), taps=512), softening, temperature
    )
    assert ripple(judged.direct.sound[:, 0], judged.frequency)[-1] > 3.0
    np.testing.assert_array_equal(judged.bank.taps, by_field.bank.taps)


def test_without_a_field_weight_all_listeners_hear_what_is_wanted(make_panel, make_plate, six):
    ears = [SoundListener(name=name, position=(x, 0.1, 0.5)) for name, x in (("left", -0.3), ("right", 0.5))]
    sound = PanelSound(listener=tuple(ears), field_weight=1e-6, level=0.0)
    panel = panel_with(make_panel, six, sound, aim="listeners")
    plate = make_plate(panel)
    aimed, amplitude, _, filters = designed(plate, panel)
    relative = aimed.relative(plate.space, amplitude, filters, np.ones(len(filters), dtype=bool))
    np.testing.assert_allclose(relative, 1.0, atol=1e-3)


def test_a_quiet_zone_is_quieter_the_more_it_weighs(make_panel, make_plate, six):
    ears = tuple(
        SoundListener(name=name, position=(x, 0.1, 0.5), zone=name) for name, x in (("left", -0.3), ("right", 0.5))
    )
    heard = []
    for weight in (0.0, 10.0, 1e4):
        sound = PanelSound(listener=ears, quiet_weight=weight, field_weight=0.1)
        panel = panel_with(make_panel, six, sound, aim="listeners", zone="left")
        plate = make_plate(panel)
        aimed, amplitude, _, filters = designed(plate, panel)
        assert aimed.loud.tolist() == [True, False]
        inside = aimed.band
        heard.append(np.abs(aimed.relative(plate.space, amplitude[:, inside], filters[inside], inside)))
    quiet = [20.0 * np.log10(one[1]).mean() for one in heard]
    assert quiet[0] > quiet[1] + 6.0 > quiet[2] + 12.0
    np.testing.assert_allclose(heard[1][0], 1.0, atol=0.2)


def test_a_weight_on_power_from_outside_the_target_lowers_it(make_panel, make_plate, six):
    shares = []
    for weight in (0.0, 30.0):
        panel = panel_with(make_panel, six, PanelSound(power_weight=weight), aim="listeners")
        plate = make_plate(panel)
        aimed, amplitude, _, filters = designed(plate, panel)
        field = np.einsum("nfr,fn,kr->fk", amplitude, filters, plate.space.deflection)[..., None]
        lines = panel.filters.frequency
        outside = (1.0 - plate.grid.target)[:, None] * field
        power, whole = (aimed.sources.power(one, lines)[:, 0, 0].real for one in (outside, field))
        shares.append(float((power / whole)[aimed.band].mean()))
    assert shares[1] < 0.7 * shares[0]


def test_drive_over_the_rating_scales_the_sound_and_keeps_its_shape(make_panel, make_plate, six, softening):
    panel = panel_with(make_panel, six, aim="listeners")
    even = focus(make_plate(panel), panel, softening, np.array([20.0]))
    peak = peak_drive(even.bank.taps[0]).max()
    rated = tuple(patch.model_copy(update={"rated_field": 0.25 * peak / patch.thickness}) for patch in panel.patch)
    weak = panel.model_copy(update={"patch": rated})
    held = focus(make_plate(weak), weak, softening, np.array([20.0]))
    assert peak_drive(held.bank.taps[0]).max() == pytest.approx(0.25 * peak)
    np.testing.assert_allclose(np.abs(held.direct.sound), 0.25 * np.abs(even.direct.sound), rtol=1e-6)
    np.testing.assert_allclose(held.direct.contrast, even.direct.contrast, rtol=1e-6)


def test_filters_robust_to_their_thermometer_keep_more_of_the_sound(make_panel, make_plate, six, softening):
    """Designed at 40 °C, played at 36 and 44 °C."""
    errors = []
    for width in (0.0, 5.0):
        panel = panel_with(make_panel, six, aim="listeners", thermometer_error=width, reference_temperature=40.0)
        found = focus(make_plate(panel), panel, softening, np.array([36.0, 44.0]))
        errors.append(np.abs(found.fixed.sound - 1.0).mean())
    assert errors[1] < errors[0]


def test_the_aim_is_for_stif(make_panel, make_plate, six, softening):
    panel = panel_with(make_panel, six, aim="volume")
    with pytest.raises(ValueError, match="aim 'volume' is for the method stif; time-reversal has no choice"):
        focus(make_plate(panel), panel, softening, np.array([20.0]), "time-reversal")


def test_a_grid_too_coarse_for_the_wavelength_is_refused(make_panel, make_plate, six, softening):
    panel = panel_with(make_panel, six, aim="listeners").model_copy(update={"grid": (8, 6)})
    with pytest.raises(
        ValueError, match=r"points .* mm apart are too coarse for 500 Hz, where the wavelength of the plate"
    ):
        focus(make_plate(panel), panel, softening, np.array([20.0]))


def test_absurd_declarations_are_refused_with_a_sentence(make_panel, six):
    ear = {"name": "ear", "position": (0.1, 0.1, 0.6)}
    for wrong, said in (
        ({"listener": ({"name": "in the panel", "position": (0.1, 0.1, 0.0)},)}, r"0\.01"),
        ({"sound_speed": 34.3}, "270"),
        ({"density": 1204.0}, "2"),
        ({"listener": (ear, ear)}, "two listeners are named 'ear'"),
        ({"curve": ((200.0, 0.0), (100.0, 0.0))}, "100 Hz after 200 Hz"),
        ({"field_weight": 0.0, "sound_weight": 0.0}, "nothing is asked for"),
    ):
        with pytest.raises(ValidationError, match=said):
            PanelSound(**wrong)
    with pytest.raises(ValidationError, match=r"zone 'driver' has no listener; zones of listeners: 'left'"):
        panel_with(make_panel, six, PanelSound(listener=(ear | {"zone": "left"},)), aim="listeners", zone="driver")
    for wrong in ({"level": 0.0}, {"design": "inverse-fft"}, {"regularisation": "truncation"}):
        with pytest.raises(ValidationError, match=r"aim 'listeners' has a level of its own"):
            Filters(aim="listeners", **wrong)
    with pytest.raises(ValidationError, match="zone 'left' is for the aim 'listeners'"):
        Filters(zone="left")
