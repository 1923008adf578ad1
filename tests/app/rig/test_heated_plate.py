"""The simulated plate behind the air of its oven: lag and gradient of one heat equation."""

import json
import re

import numpy as np
import pytest

from analysis.recordings.sweep_point import SweepPoint
from app.files.campaign_error import CampaignFileError
from app.files.declarations.experiment import AcquiredExperiment, read_acquired_experiment
from app.files.declarations.simulation_section import HeatInOven
from app.files.shipped import shipped
from app.rig import simulated_rig
from app.rig.simulated_rig import PlateBehindAir
from simulation.state.plate_state import Circumstances, PlateState


@pytest.fixture(scope="module")
def experiment() -> AcquiredExperiment:
    return read_acquired_experiment(shipped("quick-rig.toml")).on("simulated")


def lag(plate, convection, heat):
    """Mean of a slab behind air that warms steadily: ρ c h/2 (1/α + h/6k), s."""
    half = 0.5 * plate.thickness
    return plate.density * heat.specific_heat * half * (1.0 / convection + half / (3.0 * heat.conductivity))


@pytest.mark.parametrize("convection", [8.0, 40.0])
def test_in_even_air_the_lag_is_the_slab_s(experiment, convection):
    heat = HeatInOven(convection=convection)
    found = PlateBehindAir.of(experiment.recorded(experiment.sample_rate), heat)
    assert found.lag == pytest.approx(lag(experiment.plate, convection, heat), rel=0.005)
    assert found.capacity == pytest.approx(experiment.plate.mass * heat.specific_heat, rel=1e-9)
    xi = np.linspace(-1.0, 1.0, 7)
    assert np.abs(found.uneven(xi, xi)).max() < 1e-6 * found.lag


def test_where_more_air_passes_the_plate_is_less_behind(experiment):
    """Polymer conducts along the plate over 6 mm only: away from edges each place lags as a slab of its own."""
    heat = HeatInOven(convection=20.0, uneven=(0.8, 0.0))
    found = PlateBehindAir.of(experiment.recorded(experiment.sample_rate), heat)
    xi = np.array([-0.7, 0.0, 0.7])
    alone = np.array([lag(experiment.plate, 20.0 * (1.0 + 0.4 * x), heat) for x in xi])
    apart = found.uneven(xi, np.zeros(3))
    assert apart[2] - apart[0] == pytest.approx(alone[0] - alone[2], rel=0.02)
    everywhere = [lag(experiment.plate, 20.0 * (1.0 + 0.4 * x), heat) for x in np.linspace(-1.0, 1.0, 201)]
    assert found.lag == pytest.approx(np.mean(everywhere), rel=0.01)


def test_on_a_ramp_up_the_side_with_more_air_is_warmer_and_on_the_way_down_colder(experiment):
    recorded = experiment.recorded(experiment.sample_rate)
    effect = PlateBehindAir.of(recorded, HeatInOven(convection=20.0, uneven=(0.8, 0.0))).effect
    xi, lines = np.array([-0.8, 0.8]), np.array([200.0])
    plain = PlateState.baseline(xi, np.zeros(2), experiment.simulation.laws.laws().local(30.0), 30.0, lines)
    for rate, sign in ((0.02, 1.0), (-0.02, -1.0), (0.0, 0.0)):
        around = Circumstances.of(recorded, SweepPoint(30.0, rate, 1.0), lines)
        state = effect.apply(plain, around, {"share": 1.0})
        assert np.sign(state.temperature[1] - state.temperature[0]) == sign


def test_the_simulated_oven_has_the_plate_of_the_heat_equation(experiment, tmp_path, monkeypatch):
    behind = PlateBehindAir.of(experiment.recorded(experiment.sample_rate), HeatInOven(convection=10.0))
    chambers = []
    monkeypatch.setattr(simulated_rig, "simulated_parts", lambda *_, chamber, **__: chambers.append(chamber))

    def silent(drive, _rate, _temperature):
        return np.zeros((len(experiment.cards.responses), drive.size))

    simulated_rig.parts_around(experiment, experiment.simulation, silent, tmp_path / "x.toml", behind)
    (chamber,) = chambers
    assert chamber.rates()[1, 0] == pytest.approx(1.0 / behind.lag)
    assert chamber.plate_capacity == pytest.approx(experiment.plate.mass * 1900.0)


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("uneven = [1.5, 0.8]", "leaves a corner without convection; allowed: together below 2"),
        ("uneven = [2.5, 0.0]", "simulation.heat.uneven"),
        ("convection = 0.0", "simulation.heat.convection"),
        ("convecton = 5.0", "did you mean convection?"),
    ],
)
def test_heat_that_cannot_be_is_refused(tmp_path, line, said):
    text = shipped("quick-rig.toml").read_text(encoding="utf-8") + f"\n[simulation.heat]\n{line}\n"
    path = tmp_path / "rig.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(CampaignFileError, match=re.escape(said)):
        read_acquired_experiment(path)


def test_what_a_campaign_is_to_find_is_not_written_into_it(tmp_path):
    text = shipped("quick-rig.toml").read_text(encoding="utf-8") + "\n[simulation.heat]\nuneven = [0.5, 0.0]\n"
    path = tmp_path / "rig.toml"
    path.write_text(text, encoding="utf-8")
    declared = read_acquired_experiment(path)
    assert declared.simulation.heat.uneven == (0.5, 0.0)
    assert "uneven" not in json.dumps(declared.model_dump(mode="json"))
