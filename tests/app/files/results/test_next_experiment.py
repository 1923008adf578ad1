"""The experiment of a planned campaign: what `flexura acquire` would read, changed as the plan wants it."""

from pathlib import Path

import pytest

from analysis.gap.plan.measurement import Measurement, campaigns, hand_tools, placed
from app.files.declarations.experiment import read_acquired_experiment
from app.files.results.next_experiment import reach_of, rig_table, write_next_experiment
from app.files.settings_toml import read_table

EXAMPLES = Path(__file__).parents[4] / "examples"
SIMULATED, REAL = EXAMPLES / "hidden-effect.toml", EXAMPLES / "paper-protocol.toml"


def planned(file: Path) -> dict[str, Measurement]:
    experiment = read_acquired_experiment(file)
    recorded = experiment.recorded(experiment.sample_rate)
    found = [*campaigns(recorded, reach_of(experiment)), *placed(recorded)]
    return {one.key: one for one in found}


@pytest.mark.parametrize("file", [SIMULATED, REAL], ids=["simulated", "real"])
def test_every_campaign_of_a_plan_can_be_acquired(file: Path, tmp_path: Path) -> None:
    known = planned(file)
    assert {"both_ramps", "faster_ramp", "second_level", "wider_band", "further_sensor"} <= set(known)
    for key, one in known.items():
        target = tmp_path / f"{key}.toml"
        said = write_next_experiment(target, read_table(file), one)
        assert ("put in" in said) == (key == "further_sensor"), said
        written = read_acquired_experiment(target)
        assert one.experiment is not None
        protocol = written.recorded(written.sample_rate).protocol
        wanted = one.experiment.protocol
        assert protocol.temperatures == pytest.approx(wanted.temperatures)
        assert (protocol.directions, protocol.levels) == (wanted.directions, wanted.levels)
        assert (protocol.band, protocol.ramp_rate) == (wanted.band, pytest.approx(wanted.ramp_rate))


def test_a_further_sensor_gets_a_place_and_a_terminal(tmp_path: Path) -> None:
    one = planned(SIMULATED)["further_sensor"]
    write_next_experiment(tmp_path / "next.toml", read_table(SIMULATED), one)
    written = read_acquired_experiment(tmp_path / "next.toml")
    assert written.sensor[-1].point == one.place
    assert written.cards.responses == ("cDAQ1Mod1/ai1", "cDAQ1Mod1/ai2")


def test_what_the_rig_cannot_do_is_not_planned() -> None:
    """The output card ends at 4.24 V, the oven at 65 degrees, which the lead of a ramp must not pass."""
    reach = reach_of(read_acquired_experiment(SIMULATED))
    assert reach.level == 4.24
    assert reach.temperatures[1] == pytest.approx(61.0)
    assert "other_temperatures" not in planned(SIMULATED)


def test_a_simulated_campaign_does_not_tell_what_its_plate_is(tmp_path: Path) -> None:
    """Its folder holds no laws: only the experiment's file, named, can be planned from."""
    assert rig_table(tmp_path, None) is None
    table = rig_table(tmp_path, SIMULATED)
    assert table is not None
    assert table["simulation"]["laws"]["temperature"][0] == -10.0


def test_a_tool_in_the_hand_is_no_experiment(tmp_path: Path) -> None:
    experiment = read_acquired_experiment(SIMULATED)
    tool = hand_tools(experiment.recorded(experiment.sample_rate))[0]
    with pytest.raises(ValueError, match="scale is no campaign"):
        write_next_experiment(tmp_path / "next.toml", read_table(SIMULATED), tool)
