"""The plain dense trainer, and filters whose dependence on temperature is known."""

import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import numpy as np
import pytest

from analysis.focusing.fir import FirBank


@pytest.fixture(scope="session")
def dense():
    path = Path(__file__).parents[3] / "benchmarks" / "dense_bayesian.py"
    spec = spec_from_file_location("dense_bayesian", path)
    module = module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


def ringing(temperature, taps=64, actuators=2):
    """Decaying tones (T, N, M) whose pitch falls with temperature, as a plate's modes do."""
    t = np.arange(taps) / 8_000.0
    n = np.arange(actuators)[:, None]
    x = np.asarray(temperature, dtype=float)[:, None, None]
    pitch = 300.0 * np.exp(-0.008 * x)
    first = np.sin(2 * np.pi * (1.0 + 0.4 * n) * pitch * t + 0.3 * n)
    second = 0.5 * np.cos(2 * np.pi * (1.7 + 0.2 * n) * pitch * t)
    return 1e-3 * (first + second) * np.exp(-t * 200.0)


@pytest.fixture(scope="session")
def tones():
    return ringing


@pytest.fixture(scope="session")
def thirteen():
    temperature = np.arange(0.0, 61.0, 5.0)
    return FirBank(ringing(temperature), temperature, 8_000.0, 16)
