"""Measured modes of the shipped recording beside its twin's, from an identification and from modes.h5."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from analysis.identification.settings import Settings
from analysis.material import LocalLaws
from analysis.recordings.campaign import Campaign
from app.files.campaigns.loading import load_campaign
from app.files.results.laws_file import load_pairing
from app.files.results.pairing_json import checked_pairing, pairing_record, shown
from app.stages import identify, update
from app.stages.comparison.pairing import measured_sweeps, paired_sweeps
from app.stages.identify_options import Wanted
from app.stages.update import UpdateRequest
from app.twins.campaign_twin import campaign_twin


def silent(stage: str, share: float) -> None:
    pass


@pytest.fixture(scope="module")
def campaign(cut_recording: Callable[[Path, tuple[int, ...]], None], tmp_path_factory) -> Campaign:
    folder = tmp_path_factory.mktemp("pairing") / "plate"
    cut_recording(folder, (0, 20, 60))
    return load_campaign(folder)


@pytest.fixture(scope="module")
def updating(campaign: Campaign) -> update.Updating:
    return update.compute(UpdateRequest(campaign), silent)


def test_strong_modes_of_a_good_campaign_pair_within_a_tenth_of_a_bandwidth(updating: update.Updating) -> None:
    """The recording was computed by another solver; where modes overlap, one measured mode stands for two."""
    pairing = updating.pairing
    assert pairing is not None
    assert pairing.fits
    (pairs,) = pairing.before.sweeps
    assert pairs.temperature == pytest.approx(20.0, abs=0.1)
    assert pairs.count[1] >= 8
    assert pairs.share >= 0.85
    good = pairs.matched & pairs.measured.strong[pairs.measured_index]
    assert np.median(np.abs(pairs.difference[good])) < 1e-3
    assert np.median(pairs.damping[good]) == pytest.approx(1.0, abs=0.02)
    assert np.median(pairs.agreement[good]) > 0.99


def test_modes_are_taken_from_the_run_where_they_were_identified(
    campaign: Campaign, updating: update.Updating, tmp_path: Path
) -> None:
    """Residues have the signs of the channels as updating corrected them; other recordings' modes do not count."""
    wanted = Wanted(Settings(), "hysteretic", "auto", None)
    found = identify.compute(campaign, wanted, silent)
    identify.save(tmp_path, campaign, found, wanted)
    inverted = replace(updating.frf, h=-updating.frf.h)
    for frf, sign in ((updating.frf, 1.0), (inverted, -1.0)):
        measured = measured_sweeps(campaign, frf, updating.updated, silent, run=tmp_path, mains=50.0)
        assert measured is not None
        assert measured.source == "modes.h5"
        assert list(measured.modes) == [0, 1, 2]
        np.testing.assert_array_equal(measured.modes[1].poles, found.tracked.modes[1].poles)
        np.testing.assert_array_equal(measured.modes[1].residues, sign * found.tracked.modes[1].residues)
    other = replace(campaign, hashes={**campaign.hashes, "campaign.toml": "another"})
    again = measured_sweeps(other, updating.frf, updating.updated, silent, run=tmp_path, mains=50.0)
    assert again is not None
    assert again.source == "identified"


def test_a_twin_of_another_material_is_no_fit(campaign: Campaign, updating: update.Updating) -> None:
    twin = campaign_twin(campaign.experiment, silent)
    laws = [
        LocalLaws.of_material(0.81 * e, nu, eta, reference=float(t))
        for (e, nu, eta), t in zip(updating.updated.constants, updating.updated.temperature, strict=True)
    ]
    answers = np.array([updating.updated.gain * twin.frf(law, updating.frf.frequency) for law in laws])
    wrong = replace(updating.updated, misfit=np.full(3, 0.9))
    pairs = paired_sweeps(campaign.experiment, updating.frf, wrong, updating.measured, twin, laws, answers)
    assert pairs is not None
    assert pairs.sweeps[0].share < 0.5
    assert not pairs.fits


def test_the_record_is_that_of_the_pairs_and_comes_back_from_laws_h5(
    campaign: Campaign, updating: update.Updating, tmp_path: Path
) -> None:
    update.save(tmp_path, UpdateRequest(campaign), updating)
    record = load_pairing(tmp_path / "laws.h5")
    assert record == pairing_record(updating.pairing)
    assert record is not None
    sweep = shown(record)
    assert (sweep["matched"], sweep["strong"]) == updating.pairing.before.sweeps[0].count  # type: ignore[union-attr]
    first = sweep["pairs"][0]
    assert first["difference"] == pytest.approx(first["computed_hz"] / first["measured_hz"] - 1.0)


@pytest.mark.parametrize(
    ("record", "said"),
    [
        ([], "a table with a list of sweeps"),
        ({"sweeps": []}, "lacks fit"),
        (
            {"sweeps": [], "fit": True, "said": "", "likely_reason": "", "measured_modes": "", "shown": 0}
            | {"sweeps_after": None},
            "shows sweep 0; 0 are there",
        ),
    ],
)
def test_other_records_are_refused(record: object, said: str) -> None:
    with pytest.raises(ValueError, match=said):
        checked_pairing(record)
