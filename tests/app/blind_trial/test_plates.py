"""Plates of every kind: what drives and reads them, and that all of it has room."""

from pathlib import Path

import numpy as np
import pytest

from analysis.experiment import Experiment
from app.blind_trial.experiments import any_declaration
from app.blind_trial.plates import DRIVEN, plate_kind
from app.blind_trial.trial import CAMPAIGNS_PER_PLATE, Trial


def declared(number: int, seed: int) -> Experiment:
    return any_declaration(plate_kind(number, np.random.default_rng(seed)))


@pytest.mark.parametrize("number", range(6))
def test_every_plate_is_one_that_a_file_could_declare(number: int) -> None:
    """Patches, points and outline are checked where they are read; patches stay clear of every edge."""
    for seed in range(30):
        experiment = declared(number, seed)
        assert (experiment.plate.outline is None) == (number % 2 == 0)
        forced = [one.quantity == "force" for one in experiment.inputs]
        wanted = {"patch": [False], "exciter": [True], "two patches": [False, False]}
        assert forced == wanted[DRIVEN[number % len(DRIVEN)]]
        assert 1 <= len(experiment.outputs) <= 3
        assert 900.0 < experiment.plate.density < 1300.0


def test_a_hundred_campaigns_meet_every_kind_of_plate(tmp_path: Path) -> None:
    trial = Trial(tmp_path, 4 * CAMPAIGNS_PER_PLATE, 3, ("null", "single", "pair", "outside", "ablated"))
    by_plate: dict[int, set[str]] = {}
    for assignment in trial.assignments:
        by_plate.setdefault(trial.plates.index(trial.plate(assignment)[0]), set()).add(assignment.kind)
    assert {kind.inputs for kind in trial.plates} == {("A1",), ("exciter",), ("A1", "A2")}
    assert all(len(kinds) == 5 for kinds in by_plate.values())
