"""A declared experiment that every effect is available for, and a plate in the middle of it."""

from collections.abc import Callable

import numpy as np
import pytest

from analysis.experiment import Experiment, Patch
from analysis.material import LocalLaws
from analysis.recordings.sweep_point import SweepPoint
from simulation.state.plate_state import Circumstances, PlateState

Trial = Callable[..., tuple[Circumstances, PlateState]]


@pytest.fixture(scope="session")
def experiment(declare: Callable[..., Experiment], patches: list[Patch]) -> Experiment:
    return declare(patches, (100.0, 1500.0), strings=((0.03, 0.187), (0.21, 0.187)))


@pytest.fixture(scope="session")
def accelerometers(declare: Callable[..., Experiment], patches: list[Patch]) -> Experiment:
    """Declare a hammer and two accelerometers without a mass, and a patch that is held at 0 V."""
    table = declare(patches, (100.0, 1500.0)).model_dump()
    return Experiment.model_validate(
        table
        | {
            "patch": [table["patch"][0] | {"role": "shorted"}],
            "drive": [{"id": "hammer", "point": (0.07, 0.06)}],
            "sensor": [
                {"id": name, "kind": "acceleration", "point": point}
                for name, point in (("acc 1", (0.17, 0.12)), ("acc 2", (0.1, 0.15)))
            ],
        }
    )


@pytest.fixture
def trial(experiment: Experiment) -> Trial:
    """Return what makes the circumstances of one sweep and the baseline's state in them."""

    def make(
        temperature: float = 25.0,
        rate: float = 0.0,
        level: float = 1.0,
        frequency: tuple[float, ...] = (250.0, 500.0),
        declared: Experiment = experiment,
    ) -> tuple[Circumstances, PlateState]:
        f = np.array(frequency)
        xi, zeta = np.array([-1.0, 0.0, 1.0, 1.0, 0.5]), np.array([-1.0, 0.0, 1.0, -1.0, -0.25])
        laws = LocalLaws(
            30.0,
            np.array([np.log(2e9), 0.38, np.log(0.06)]),
            np.array([-0.02, 0.002, -0.01]),
            np.array([1e-4, 0.0, 1e-4]),
        )
        point = SweepPoint(temperature, rate, level)
        return Circumstances.of(declared, point, f), PlateState.baseline(xi, zeta, laws, temperature, f)

    return make
