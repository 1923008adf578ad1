"""Wrong declarations of the shipped recording: what is wrong is named, and nothing where something else is."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from analysis.declaration.plate_material import material_box
from analysis.experiment import Experiment
from analysis.identification.automatic import identify
from analysis.identification.over_temperature.tracking import sweep_measured
from analysis.identification.pole_residue import COMPLEX_E_F_G
from analysis.identification.settings import Settings
from analysis.material import MaterialBox
from analysis.pairing.assignment import ModeList
from analysis.pairing.coarse_trial import SweepModes, tried
from analysis.recordings.frf import campaign_frf
from app.files.campaigns.loading import load_campaign
from app.stages.comparison import declaration_check
from app.stages.comparison.declaration_check import exchanged_channels, likely_reason
from simulation.reduction.coarse_plate import CoarsePlate

HAMMER = Path(__file__).parents[3] / "examples" / "hammer-plate"


def silent(stage: str, share: float) -> None:
    pass


def sweep_of(folder: Path, number: int) -> tuple[Experiment, SweepModes]:
    campaign = load_campaign(folder)
    frf = campaign_frf(campaign)
    modes = identify(sweep_measured(frf, number), Settings(terms=(COMPLEX_E_F_G,)))
    used = ~frf.excluded
    h = frf.h[number][:, used]
    rms = np.sqrt((np.abs(h) ** 2).mean(axis=1))
    deviation = np.sqrt(frf.variance[number][:, used])
    temperature = float(frf.temperature[number])
    listed = ModeList.measured(modes, rms)
    return campaign.experiment, SweepModes(temperature, frf.frequency[used], h, deviation, listed, COMPLEX_E_F_G)


@pytest.fixture(scope="module")
def measured(
    cut_recording: Callable[[Path, tuple[int, ...]], None], tmp_path_factory: pytest.TempPathFactory
) -> tuple[Experiment, SweepModes]:
    folder = tmp_path_factory.mktemp("reason") / "plate"
    cut_recording(folder, (0, 20, 60))
    return sweep_of(folder, 1)


def plate(experiment: Experiment, **changes: object) -> Experiment:
    return experiment.model_copy(update={"plate": experiment.plate.model_copy(update=changes)})


def test_the_right_declaration_pairs_on_a_coarse_model(measured: tuple[Experiment, SweepModes]) -> None:
    experiment, sweep = measured
    box = material_box(experiment.plate.material)
    found = tried(CoarsePlate.of(experiment, box), box, sweep)
    assert found.share >= 0.85
    assert found.youngs_modulus == pytest.approx(2.26e9, rel=0.04)  # that of update at 20 °C


def test_a_thickness_that_no_declared_modulus_makes_up_for_is_told(
    measured: tuple[Experiment, SweepModes],
) -> None:
    experiment, sweep = measured
    reason = likely_reason(plate(experiment, thickness=0.0022), sweep, silent)
    assert "thickness 2.2 mm declared; the resonances at 20 °C say" in reason.sentence
    assert reason.wrong_declaration


@pytest.mark.slow
def test_a_patch_declared_at_another_place_is_told_with_its_place(measured: tuple[Experiment, SweepModes]) -> None:
    experiment, sweep = measured
    a1, s1 = experiment.patch
    wrong = experiment.model_copy(update={"patch": (a1, s1.model_copy(update={"center": (0.15, 0.08)}))})
    reason = likely_reason(wrong, sweep, silent)
    assert "S1 stands at 0.0" in reason.sentence
    place = reason.sentence.split("S1 stands at ")[1].split(" m,")[0]
    np.testing.assert_allclose([float(word) for word in place.split(", ")], s1.center, atol=0.012)


@pytest.mark.slow
def test_a_wrong_length_is_told(measured: tuple[Experiment, SweepModes]) -> None:
    experiment, sweep = measured
    reason = likely_reason(plate(experiment, length_y=0.211), sweep, silent)
    assert "length_y is 0.190 m, not 0.211 m as declared" in reason.sentence


@pytest.mark.slow
def test_nothing_is_named_where_two_things_are_wrong(measured: tuple[Experiment, SweepModes]) -> None:
    experiment, sweep = measured
    a1, s1 = experiment.patch
    wrong = plate(experiment, length_y=0.215).model_copy(
        update={"patch": (a1, s1.model_copy(update={"center": (0.15, 0.08)}))}
    )
    assert likely_reason(wrong, sweep, silent).sentence.startswith("no likely reason found")


def test_exchanged_channels_are_put_in_order() -> None:
    """FRFs of the coarse plate itself, the first two channels exchanged."""
    experiment, sweep = sweep_of(HAMMER, 0)
    assert len(experiment.outputs) > 1
    box = MaterialBox((60e9, 80e9), (0.3, 0.36), (1e-3, 1e-2))
    model = CoarsePlate.of(experiment, box)
    order = [1, 0, *range(2, len(experiment.outputs))]
    h = model.frf(70e9, 0.33, sweep.frequency, sweep.loss_factor)[order]
    wrong = SweepModes(20.0, sweep.frequency, h, sweep.deviation, sweep.modes, sweep.terms)
    (other,) = exchanged_channels(experiment, box, wrong)
    np.testing.assert_array_equal(other.sweep.h, h[order])
    names = [output.id for output in experiment.outputs]
    assert f"{names[0]} is recorded as {names[1]}" in other.words
    right = SweepModes(20.0, sweep.frequency, h[order], sweep.deviation, sweep.modes, sweep.terms)
    assert list(exchanged_channels(experiment, box, right)) == []


def test_a_length_that_leaves_a_transducer_off_the_plate_is_no_alternative() -> None:
    """A drive in the outer fifth of a side ended the search with a traceback: point off the plate."""
    experiment, sweep = sweep_of(HAMMER, 0)
    box = MaterialBox((60e9, 80e9), (0.3, 0.36), (1e-3, 1e-2))
    across = experiment.plate.length_x
    drives = tuple(one.model_copy(update={"point": (0.9 * across, one.point[1])}) for one in experiment.drive)
    shorter = plate(experiment.model_copy(update={"drive": drives}), length_x=0.8 * across)
    assert declaration_check._tried(shorter, box, sweep) is None
