"""What a rig records of a specimen is what the sizes of effects are counted with, whatever drives and reads it."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from analysis.recordings.frf import campaign_frf
from analysis.recordings.sweep_point import SweepPoint
from app.blind_trial.effect_size import expected_frf
from app.blind_trial.experiments import any_declaration, draw_experiments
from app.blind_trial.making import record_on_rig
from app.blind_trial.plates import Driven, draw_plate
from app.blind_trial.specimen import Specimen
from app.files.campaigns.loading import load_campaign
from simulation.reduction.effect_reduction import reduce_with_effects

from .conftest import BAND, BOX, COARSE, ROUGH

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("driven", ["patch", "exciter", "two patches"])
def test_recorded_and_computed_frfs_differ_by_the_noise(tmp_path: Path, driven: Driven) -> None:
    """Gains, sensitivities, levels, inputs and noise are the same in both; readings err by .05 K."""
    kind = dataclasses.replace(draw_plate(np.random.default_rng(5), driven), band=BAND)
    declared = any_declaration(kind)
    operators = reduce_with_effects(declared, BOX, fineness=COARSE, training=ROUGH)[0]
    experiments = draw_experiments(np.random.default_rng(6), kind, "plate", ("up",), (1.0, 2.0))
    specimen = Specimen.of(experiments, operators)
    softening = {"a": 0.02, "b": 0.1}  # weak: a resonance that folds over answers beyond the record's end
    hidden = {"amplitude_softening": softening}
    _, noise = expected_frf(specimen, 0.05, np.random.default_rng(7))
    truth, folder = tmp_path / "truth.json", tmp_path / "campaign"
    truth.write_text("{}", encoding="utf-8")
    record_on_rig(specimen, hidden, noise, truth, folder)
    campaign = load_campaign(folder)
    assert [one.id for one in campaign.experiment.inputs] == list(kind.inputs)
    frf, transfer = campaign_frf(campaign), specimen.transfer(hidden)
    used = ~frf.excluded
    louder = specimen.gains / specimen.gains[0]
    away = []
    for t, source in enumerate(frf.driven_by):
        point = SweepPoint(float(frf.temperature[t]), 0.0, float(frf.level[t] * louder[source]), int(source))
        h = specimen.gains[source] * transfer(point, frf.frequency[used])
        away.append((np.abs(frf.h[t][:, used] - h) ** 2 / frf.variance[t][:, used]).mean(-1))
    for t, source in enumerate(frf.driven_by):
        same = (frf.driven_by == source) & (frf.level == frf.level[t])
        assert np.mean(np.array(away)[same]) == pytest.approx(1.0, abs=0.1)
