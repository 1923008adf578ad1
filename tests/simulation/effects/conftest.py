"""A declared experiment that every effect is available for, and a plate in the middle of it."""

from collections.abc import Callable

import numpy as np
import pytest

from analysis.experiment import Experiment, Patch
from analysis.local_laws import LocalLaws
from analysis.sweep_point import SweepPoint
from simulation.state.plate_state import Circumstances, PlateState

Trial = Callable[..., tuple[Circumstances, PlateState]]


@pytest.fixture(scope="session")
def experiment(declare: Callable[..., Experiment], patches: list[Patch]) -> Experiment:
    return declare(patches, (100.0, 1500.0), strings=((0.03, 0.187), (0.21, 0.187)))


@pytest.fixture
def trial(experiment: Experiment) -> Trial:
    """Return what makes the circumstances of one sweep and the baseline's state in them."""

    def make(
        temperature: float = 25.0,
        rate: float = 0.0,
        level: float = 1.0,
        frequency: tuple[float, ...] = (250.0, 500.0),
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
        return Circumstances.of(experiment, point, f), PlateState.baseline(xi, zeta, laws, temperature, f)

    return make
