"""The recording that ships with the project."""

from pathlib import Path

import pytest

from app.files.campaigns.channels import read_experiment
from app.files.campaigns.loading import load_campaign
from app.files.provenance import sha256

EXAMPLE = Path(__file__).resolve().parents[2] / "examples/pp-plate"
ORIGIN = EXAMPLE.parents[2] / "shared/data/campaigns/pp-plate-nominal"


def test_is_a_faultless_campaign() -> None:
    campaign = load_campaign(EXAMPLE)
    assert [round(sweep.oven_temperature) for sweep in campaign.sweeps] == list(range(0, 61, 4))
    assert campaign.sweeps[0].responses.shape == (1, 3, 20480)


def test_is_small_and_gives_nothing_away() -> None:
    files = [path for path in EXAMPLE.rglob("*") if path.is_file()]
    assert sum(path.stat().st_size for path in files) <= 8_000_000
    assert {path.suffix for path in files} == {".toml", ".md", ".tdms"}  # the truth behind it is not among them


@pytest.mark.shared
def test_is_a_selection_of_the_campaign_it_says() -> None:
    if not ORIGIN.is_dir():
        pytest.skip("the recorded campaigns are not beside this checkout")
    here, there = read_experiment(EXAMPLE), read_experiment(ORIGIN)
    assert set(here.protocol.temperatures) < set(there.protocol.temperatures)
    whole = there.protocol.model_copy(update={"temperatures": here.protocol.temperatures})
    assert here.model_copy(update={"title": there.title}) == there.model_copy(update={"protocol": whole})
    for path in (EXAMPLE / "sweeps").iterdir():
        assert sha256(path) == sha256(ORIGIN / "sweeps" / path.name)
