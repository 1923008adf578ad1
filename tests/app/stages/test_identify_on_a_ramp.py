"""The identify stage hands the protocol's ramp and timing to the correction of modes."""

import csv
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from analysis.experiment import Protocol
from analysis.identification.settings import Settings
from analysis.recordings.campaign import Campaign
from app.files.results.modes_file import load_modes, save_modes, write_table
from app.stages import identify
from app.stages.identify_options import Wanted
from tests.sweeps_on_a_ramp import PROTOCOL, modes_at, on_a_ramp


def identified(monkeypatch: pytest.MonkeyPatch, protocol: Protocol) -> identify.IdentifiedCampaign:
    frf = on_a_ramp(PROTOCOL, noise=0.01)
    monkeypatch.setattr(identify, "campaign_frf", lambda *_, **__: frf)
    experiment = SimpleNamespace(outputs=[SimpleNamespace(patch=None, quantity="displacement")], protocol=protocol)
    air_only = SimpleNamespace(plate_temperature_start=None)
    campaign: Any = SimpleNamespace(
        name="plate", hashes={}, experiment=experiment, sweeps=[air_only] * len(frf.temperature)
    )
    wanted = Wanted(Settings(), "hysteretic", "auto", None)
    return identify.compute(cast(Campaign, campaign), wanted, lambda *_: None)


def test_results_hold_the_modes_at_the_stated_temperatures_and_rebuild_the_frfs(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    found = identified(monkeypatch, PROTOCOL)
    save_modes(tmp_path / "modes.h5", found.tracked, {})
    write_table(tmp_path / "modes.csv", found.tracked)
    again = load_modes(tmp_path / "modes.h5")
    np.testing.assert_array_equal(again.poles, found.tracked.poles)
    left = found.frf.h - again.synthesis(found.frf.frequency)
    assert (np.abs(left) ** 2 / found.frf.variance).mean() == pytest.approx(1.0, abs=0.05)
    with (tmp_path / "modes.csv").open(encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["status"] == "kept"]
    true, _ = modes_at(np.array([float(row["temperature_c"]) for row in rows]))
    f, sigma = (np.array([float(row[name]) for row in rows]) for name in ("frequency_hz", "sigma_frequency_hz"))
    nearest = np.abs(true - f[:, None]).min(axis=1)
    assert np.sqrt(np.mean((nearest / sigma) ** 2)) < 1.4


def test_sweeps_that_do_not_say_when_frequencies_are_passed_have_a_note(monkeypatch: pytest.MonkeyPatch) -> None:
    found = identified(monkeypatch, PROTOCOL.model_copy(update={"taper": None, "repeats": 1}))
    assert all(modes.corrected is None for modes in found.tracked.modes)
    (note,) = found.tracked.notes
    assert note.endswith("with protocol.taper in the declaration, the drift is taken into account")
