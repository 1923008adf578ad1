"""A twin is made about patches where model updating found them, and for a misplaced sensor where one is likely."""

from pathlib import Path

import pytest

from analysis.experiment import Experiment
from app.files.campaigns.loading import load_campaign
from app.twins.campaign_twin import FAR_MOVED, offset_wanted, placed

EXAMPLE = Path(__file__).resolve().parents[3] / "examples" / "pp-plate"


@pytest.fixture(scope="module")
def experiment() -> Experiment:
    return load_campaign(EXAMPLE).experiment


def test_patches_that_moved_far_are_placed_in_rounded_steps(experiment: Experiment) -> None:
    found = {
        "patch_place A1": {"dx": -4.21e-4, "dy": 1.1e-5},
        "patch_size A1": {"along": 1.4e-4, "across": -0.9e-4},
        "patch_thickness A1": {"share": 0.021},
        "patch_place S1": {"dx": 1.0e-4, "dy": -1.0e-4},
    }
    about, made_at = placed(experiment, found)
    assert made_at == {
        "patch_place A1": {"dx": -4e-4, "dy": 0.0},
        "patch_size A1": {"along": 1.5e-4, "across": -1e-4},
        "patch_thickness A1": {"share": 0.02},
    }
    before, after = experiment.patch[0], about.patch[0]
    assert after.center == pytest.approx((before.center[0] - 4e-4, before.center[1]), abs=1e-12)
    assert after.size == pytest.approx((before.size[0] + 1.5e-4, before.size[1] - 1e-4), abs=1e-12)
    assert after.loop.bounds[0][0] == pytest.approx(before.loop.bounds[0][0] - 4e-4 - 0.75e-4, abs=1e-9)
    assert about.patch[1] == experiment.patch[1]


def test_near_the_declaration_nothing_changes(experiment: Experiment) -> None:
    near = 0.9 * FAR_MOVED
    assert placed(experiment, {"patch_place A1": {"dx": near, "dy": -near}}) == (experiment, {})
    assert placed(experiment, {}) == (experiment, {})


def test_where_the_patch_cannot_be_the_declared_one_stays(experiment: Experiment) -> None:
    beyond = {"patch_place A1": {"dx": -experiment.patch[0].center[0], "dy": 0.0}}
    assert placed(experiment, beyond) == (experiment, {})


def test_a_misplaced_sensor_is_looked_for_where_its_tolerance_does_not_cover_it(experiment: Experiment) -> None:
    tolerance = experiment.tolerances.patch_place
    assert not offset_wanted(experiment)
    assert not offset_wanted(experiment, {"patch_place S1": {"dx": 2.9 * tolerance, "dy": 0.0}})
    assert not offset_wanted(experiment, {"patch_place A1": {"dx": 9.0 * tolerance, "dy": 0.0}})
    assert offset_wanted(experiment, {"patch_place S1": {"dx": 0.0, "dy": -3.1 * tolerance}})
    known = experiment.tolerances.model_copy(update={"own": {"patch.S1.center": 2e-3}})
    wider = experiment.model_copy(update={"tolerances": known})
    assert not offset_wanted(wider, {"patch_place S1": {"dx": 0.0, "dy": -3.1 * tolerance}})
    assert offset_wanted(experiment.model_copy(update={"tolerances": experiment.tolerances.exact()}))
