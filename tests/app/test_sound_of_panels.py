"""What shipped panels sound like with filters for listeners: evenness of one, separation of two zones."""

from pathlib import Path

import numpy as np
import pytest

from analysis.focusing.over_temperature import focus
from analysis.focusing.panel import Panel, PanelSound, SoundListener
from analysis.focusing.radiated import Radiation, radiate
from analysis.radiation.measures import third_octave_levels
from app.files.declarations.panel import SECTION_2, read_panel
from app.twins.panel_twin import panel_twin
from tests.app.test_section_2_filters import polypropylene

pytestmark = pytest.mark.slow

DOOR_TRIM = Path(__file__).resolve().parents[2] / "examples" / "door-trim" / "panel.toml"
FAR = 0.6 * np.sqrt(0.5)
"""m, to the side and ahead: 0.6 m at 45 degrees."""


def heard(file: Path, temperature: list[float], sound: PanelSound, **filters: object) -> tuple[Panel, Radiation]:
    """Design filters for listeners at some temperatures, and compute what is heard of their taps."""
    declared = read_panel(file)
    panel = declared.model_copy(
        update={"filters": declared.filters.model_copy(update={"aim": "listeners", **filters}), "sound": sound}
    )
    laws = panel.plate.grown(polypropylene())
    model = panel_twin(panel, laws, lambda _stage, _share: None)
    designed = focus(model, panel, laws, np.array(temperature))
    return panel, radiate(model, panel, laws, designed.bank, temperature[0])


@pytest.mark.parametrize("taps", [128, 512])
def test_the_section_2_panel_is_even_on_its_axis_and_stays_focused(taps: int) -> None:
    """At 1 m from 110 to 540 Hz, at 0, 20 and 60 °C: third octaves within ±1 dB, mean contrast 0.78 or more."""
    _, found = heard(SECTION_2, [0.0, 20.0, 60.0], PanelSound(), taps=taps)
    inside = (found.frequency >= 110.0) & (found.frequency <= 540.0)
    level = third_octave_levels(found.relative(found.following)[:, 0][:, inside], found.frequency[inside])
    assert 0.5 * np.ptp(level, axis=-1).max() <= 1.0
    assert found.following.contrast[:, inside].mean(axis=1).min() >= 0.78


@pytest.mark.parametrize("zone", ["left", "right"])
def test_two_seats_before_a_door_trim_hear_programmes_of_their_own(zone: str) -> None:
    """Heads at 0.6 m and 45° to both sides: four fifths of the bound of any filters, in dB."""
    seats = tuple(
        SoundListener(name=name, position=(0.2 + side * FAR, 0.13, FAR), zone=name)
        for name, side in (("left", -1.0), ("right", 1.0))
    )
    sound = PanelSound(listener=seats, quiet_weight=3000.0, field_weight=0.01)
    _, found = heard(DOOR_TRIM, [20.0], sound, zone=zone)
    between, bound = found.following.zones.mean(), found.zone_bound.mean()
    assert between <= bound
    assert between >= 0.8 * bound
