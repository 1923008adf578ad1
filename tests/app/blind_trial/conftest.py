"""One plate with two patches and few modes, reduced once for all tests of the trial."""

import dataclasses
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from analysis.experiment import Experiment
from analysis.material import MaterialBox
from app.blind_trial.effect_size import EffectSize
from app.blind_trial.experiments import draw_experiments
from app.blind_trial.plates import PlateKind, draw_plate
from app.blind_trial.specimen import Specimen
from app.files.declarations.experiment import AcquiredExperiment
from simulation.meshing.plate_mesh import MeshRecipe
from simulation.reduction.basis_key import BasisTraining
from simulation.reduction.effect_operators import EffectOperators
from simulation.reduction.effect_reduction import reduce_with_effects
from simulation.reduction.reduced_model import ReducedModel
from simulation.reduction.vectors.reduce import reduce
from simulation.shell.assembly import assemble_for
from simulation.shell.fineness import Fineness

BAND = (100.0, 250.0)
BOX = MaterialBox((0.9e9, 3.6e9), (0.32, 0.46), (0.02, 0.12))
MESH = MeshRecipe(spacing=0.08, strip=1.7, edge_strip=1.7, growth=2.0, grading=0.0, pieces=1)
COARSE = Fineness(MESH, degree=3, tolerance=0.0)
ROUGH = BasisTraining(tolerance=1e-3, lines=60)


@pytest.fixture(scope="session")
def kind() -> PlateKind:
    drawn = draw_plate(np.random.default_rng(3))
    return dataclasses.replace(drawn, band=BAND, patches=drawn.patches[:2])


@pytest.fixture(scope="session")
def experiment(kind: PlateKind) -> AcquiredExperiment:
    return draw_experiments(np.random.default_rng(4), kind, "plate", ("up", "down"), (1.0,))[0]


@pytest.fixture(scope="session")
def operators(experiment: AcquiredExperiment) -> EffectOperators:
    """Operators of the specimen; they serve its twin, too."""
    declared: Experiment = experiment.recorded(experiment.sample_rate)
    return reduce_with_effects(declared, BOX, fineness=COARSE, training=ROUGH)[0]


@pytest.fixture(scope="session")
def yard(experiment: AcquiredExperiment, operators: EffectOperators) -> Iterator[EffectSize]:
    with ThreadPoolExecutor(1) as executor:
        specimen = Specimen.of([experiment], operators)
        yield EffectSize.of(specimen, specimen.twin, 0.02, np.random.default_rng(0), executor)


@pytest.fixture(scope="session")
def plain(kind: PlateKind) -> ReducedModel:
    """Return the plain twin's model."""
    model = assemble_for(kind.plate, kind.patches, BOX, BAND, fineness=COARSE)
    return reduce(model, BOX, BAND, training=ROUGH)[0]
