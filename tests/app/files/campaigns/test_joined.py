"""Campaigns of one plate, each with an actuator of its own, are one campaign."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from analysis.recordings.frf import Frf, campaign_frf
from app.files.campaign_error import CampaignFileError
from app.files.campaigns.folder import frozen_protocol, read_protocol, write_protocol
from app.files.campaigns.loading import load_campaign

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def apart(recorded: Path, run_flexura: Run) -> tuple[Path, Path]:
    """Return a campaign folder of each."""
    for actuator in ("A1", "hammer"):
        status, _, message = run_flexura("import", recorded, "--actuator", actuator)
        assert status == 0, message
    return recorded.with_name("plate-A1-campaign"), recorded.with_name("plate-hammer-campaign")


def frf_of(folder: Path) -> Frf:
    return campaign_frf(load_campaign(folder))


def test_joined_they_are_what_one_recording_of_both_is(
    recorded: Path, apart: tuple[Path, Path], run_flexura: Run
) -> None:
    both = recorded.with_name("both")
    status, _, message = run_flexura("import", *apart, "--out", both)
    assert status == 0, message
    expected, found = frf_of(recorded), frf_of(both)
    assert found.sources == expected.sources == ("A1", "hammer")
    assert found.labels == expected.labels
    for source in (0, 1):
        np.testing.assert_array_equal(found.of_source(source).h, expected.of_source(source).h)
    assert load_campaign(both).experiment == load_campaign(recorded).experiment
    status, _, message = run_flexura("import", *apart, "--out", both)
    assert (status, "unchanged" in message) == (0, True)


def test_in_another_order_inputs_stand_as_declared(apart: tuple[Path, Path], run_flexura: Run) -> None:
    """Patches before forces: the hammer's sweeps come first, and stay the hammer's."""
    both = apart[0].with_name("both")
    status, _, message = run_flexura("import", *apart[::-1], "--out", both)
    assert status == 0, message
    np.testing.assert_array_equal(frf_of(both).of_source(1).h, frf_of(apart[1]).h)


def test_an_actuator_in_both_is_told(apart: tuple[Path, Path], run_flexura: Run) -> None:
    status, _, message = run_flexura("import", apart[0], apart[0], "--out", apart[0].with_name("both"))
    assert status == 2
    assert "actuator = A1 drove in several; allowed: each in one campaign" in message
    assert not apart[0].with_name("both").exists()


def test_another_plate_is_told(recorded: Path, apart: tuple[Path, Path], run_flexura: Run) -> None:
    declaration = recorded / "campaign.toml"
    text = declaration.read_text(encoding="utf-8")
    assert "thickness = 0.003" in text
    declaration.write_text(text.replace("thickness = 0.003", "thickness = 0.004"), encoding="utf-8")
    status, _, message = run_flexura(
        "import", recorded, "--actuator", "hammer", "--out", recorded.with_name("other")
    )
    assert status == 0, message
    both = recorded.with_name("both")
    status, _, message = run_flexura("import", apart[0], recorded.with_name("other"), "--out", both)
    assert (status, both.exists()) == (2, False)
    assert f"plate = not that of {apart[0]}" in message


@pytest.mark.parametrize(
    ("words", "told"), [((), "give it"), (("--out", "both", "--actuator", "A1"), "leave it out")]
)
def test_what_joining_needs_is_told(
    apart: tuple[Path, Path], run_flexura: Run, words: tuple[str, ...], told: str
) -> None:
    status, _, message = run_flexura("import", *apart, *words)
    assert (status, told in message) == (2, True)


def test_levels_of_an_acquired_campaign_stay_volts(apart: tuple[Path, Path], run_flexura: Run) -> None:
    """A rig's levels are those of its generator, before an exciter too; a hammer's are its force."""
    hammer, both = apart[1], apart[0].with_name("both")
    protocol, experiment = read_protocol(hammer)
    write_protocol(hammer, frozen_protocol(protocol["name"], experiment, protocol["source"], acquired={}))
    status, _, message = run_flexura("import", *apart, "--out", both)
    assert status == 0, message
    campaign = load_campaign(both)
    assert campaign.experiment.level_units == ("V", "N")
    assert campaign.level_units == ("V", "V")
    assert campaign_frf(campaign).level_unit(len(campaign.sweeps) - 1) == "V"


@pytest.mark.parametrize("units", [("V",), ("V", "m"), ("N", "N"), (["V"], "N"), ("V", "N", "N")])
def test_units_that_no_input_has_are_told(apart: tuple[Path, Path], run_flexura: Run, units: Any) -> None:
    both = apart[0].with_name("both")
    status, _, message = run_flexura("import", *apart, "--out", both)
    assert status == 0, message
    protocol, experiment = read_protocol(both)
    write_protocol(both, frozen_protocol("both", experiment, protocol["source"], level_units=units))
    with pytest.raises(CampaignFileError, match="level_units"):
        load_campaign(both)
