"""A wire for a plate, and the plain nidaqmx way to the simulated cards."""

from collections.abc import Callable
from typing import Any

import nidaqmx
import numpy as np
import pytest
from numpy.typing import NDArray

from drivers.ni.simulated.servicer import InProcessChannel, SimulatedDaq
from drivers.ni.simulated.surroundings import Surroundings


def wire(drive: NDArray[np.float64], _rate: float, _temperature: NDArray[np.float64]) -> NDArray[np.float64]:
    return drive[None]


@pytest.fixture
def surroundings() -> Surroundings:
    return Surroundings(wire, {"cDAQ1Mod1/ai1": 0}, memory=0.0)


@pytest.fixture
def server(surroundings: Surroundings) -> SimulatedDaq:
    return SimulatedDaq(surroundings, seed=11)


@pytest.fixture
def new_task(server: SimulatedDaq) -> Callable[..., Any]:
    channel = InProcessChannel(server)

    def make(name: str = "") -> Any:
        return nidaqmx.Task(name, grpc_options=nidaqmx.GrpcSessionOptions(channel, ""))

    return make
