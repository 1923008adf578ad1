"""What is said of temperatures that cannot be true, in recorded and acquired campaigns."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from analysis.recordings.campaign import Campaign, Sweep
from app.files.acquisition.events import append_event
from app.files.campaigns.folder import Source, read_campaign_folder, read_sweep_file, write_sweep
from app.files.campaigns.import_recording import import_recording
from app.files.campaigns.loading import load_campaign
from app.stages.comparison.temperature_notes import label_notes, recorded_notes

RECORDED = Path(__file__).resolve().parents[4] / "examples" / "pp-plate"


def touched(sweep: Sweep, plate: float, lag: float) -> Sweep:
    """Give a sweep a sensor on the plate."""
    return replace(
        sweep,
        oven_temperature_start=plate + lag,
        oven_temperature_end=plate + lag,
        plate_temperature_start=plate,
        plate_temperature_end=plate,
    )


@pytest.fixture(scope="module")
def campaign() -> Campaign:
    read = load_campaign(RECORDED)
    lag = {"up": 2.0, "down": -2.0}
    return replace(read, sweeps=tuple(touched(one, one.temperature, lag[one.direction]) for one in read.sweeps))


def test_a_sound_campaign_has_no_note(campaign: Campaign) -> None:
    assert recorded_notes(campaign) == ()


def test_a_plate_that_is_not_where_the_oven_is_gets_a_note_with_the_sweep(campaign: Campaign) -> None:
    wrong = campaign.sweeps[5]
    failed = replace(wrong, oven_temperature_start=wrong.temperature + 17.0,
                     oven_temperature_end=wrong.temperature + 17.0)  # fmt: skip
    (note,) = recorded_notes(replace(campaign, sweeps=(*campaign.sweeps[:5], failed, *campaign.sweeps[6:])))
    assert f"the temperature of step {wrong.step} " in note


def test_of_many_doubts_some_are_named(campaign: Campaign) -> None:
    notes = recorded_notes(replace(campaign, sweeps=tuple(replace(one, doubt="why") for one in campaign.sweeps)))
    assert len(notes) == 7
    assert notes[-1] == f"and the temperature of {len(campaign.sweeps) - 6} more sweeps is in doubt"


def test_a_doubt_is_kept_in_the_file_of_the_sweep(campaign: Campaign, tmp_path: Path) -> None:
    doubted = replace(campaign.sweeps[0], doubt="reads 25.0 °C; 44.1 °C is likely")
    path = tmp_path / "sweep.h5"
    write_sweep(path, doubted, ("S1", "S2")[: len(doubted.responses)], Source("x.toml", "0" * 64))
    read, problem = read_sweep_file(path, "sweep.h5")
    assert problem is None
    assert read is not None
    assert read.doubt == doubted.doubt


def test_a_doubt_that_came_later_is_read_from_the_log(tmp_path: Path) -> None:
    folder = import_recording(RECORDED, tmp_path / "campaign").folder
    append_event(folder, {"event": "temperature in doubt", "step": 2, "what": ["drifts"], "leg": 0})
    append_event(folder, {"event": "temperature in doubt", "what": ["told live, for no sweep"], "leg": 0})
    read = read_campaign_folder(folder)
    assert {one.step: one.doubt for one in read.sweeps if one.doubt} == {2: "drifts"}
    assert [note for note in recorded_notes(read) if "drifts" in note]


def updated(temperature: Any, log_modulus: Any, direction: tuple[str, ...] = ()) -> Any:
    """Return what of FRFs and estimates is asked for."""
    count = len(temperature)
    frf = SimpleNamespace(
        temperature=temperature,
        direction=direction or ("up",) * count,
        level=np.ones(count),
        driven_by=np.zeros(count, int),
    )
    material = SimpleNamespace(youngs_modulus=np.exp(log_modulus))
    return frf, SimpleNamespace(material=material, settled=np.ones(count, bool))


def test_a_modulus_that_jumps_names_the_sweep_to_look_at(campaign: Campaign) -> None:
    """E falls by 1.2 % a kelvin; the sweep at 25 °C was made at 44 °C."""
    labels = np.arange(15.0, 46.0, 5.0)
    true = np.where(labels == 25.0, 44.0, labels)
    (note,) = label_notes(campaign, *updated(labels, -0.012 * true))
    assert "look at the sweep at 25.0 °C on the way up" in note
    assert "about 44 °C" in note
    assert label_notes(campaign, *updated(labels, -0.012 * labels)) == ()


def test_a_lag_that_two_ramps_show_is_told_where_laws_alone_are_fitted(campaign: Campaign) -> None:
    """Each modulus was 1.6 K off with a sigma of 0.3 K, and nothing said so: the misfit is the noise."""
    labels = np.arange(10.0, 51.0, 5.0)
    both, ways = np.concatenate([labels, labels[::-1]]), ("up",) * 9 + ("down",) * 9
    rate = campaign.experiment.protocol.ramp_rate / 60.0
    behind = np.where(np.array(ways) == "up", 1.0, -1.0) * 240.0 * rate
    found = updated(both, -0.02 * (both - behind), ways)
    air = [replace(one, plate_temperature_start=None, plate_temperature_end=None) for one in campaign.sweeps]
    by_air = replace(campaign, sweeps=tuple(air))
    (note,) = label_notes(by_air, *found)
    assert f"the air reads {480.0 * rate:+.1f} K on the way up" in note
    assert "lags about 240 s behind" in note
    assert label_notes(by_air, *updated(both, -0.02 * both, ways)) == ()
