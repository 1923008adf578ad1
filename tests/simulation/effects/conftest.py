"""A declared experiment that every effect is available for, and a plate in the middle of it."""

from collections.abc import Callable

import numpy as np
import pytest

from analysis.experiment import Acquisition, Attachment, Experiment, Oven, Patch, Plate, Protocol
from analysis.gap.model import SweepPoint
from analysis.local_laws import LocalLaws
from simulation.plate_state import Circumstances, PlateState

Trial = Callable[..., tuple[Circumstances, PlateState]]


@pytest.fixture(scope="session")
def experiment(plate: Plate, patches: list[Patch]) -> Experiment:
    return Experiment(
        title="every effect",
        plate=plate,
        patch=tuple(patches),
        string=(Attachment(point=(0.03, 0.187)), Attachment(point=(0.21, 0.187))),
        cable=(Attachment(point=(0.058, 0.03)),),
        acquisition=Acquisition(
            module="NI-9234", sample_rate=8533.3, input_resistance=305e3, input_capacitance=120e-12
        ),
        protocol=Protocol(
            sweep="logarithmic",
            band=(100.0, 1500.0),
            sweep_duration=1.5,
            tail=0.3,
            repeats=3,
            ramp_rate=0.4,
            temperatures=(0.0, 20.0, 40.0, 60.0),
            directions=("up", "down"),
            levels=(1.0, 2.0),
        ),
        oven=Oven(room_temperature=22.0),
    )


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
