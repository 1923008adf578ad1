"""Filters of a panel nobody computed: decaying tones whose pitch falls with temperature."""

import numpy as np
import pytest

from analysis.compensation.network import InputMap, NetworkBank
from analysis.focusing.fir import FirBank
from analysis.rendering.following import FollowingBank
from app.files.declarations.panel import SECTION_2, read_panel
from app.files.exports.shipment import Shipment
from app.files.provenance import provenance

RATE, DELAY = 8_000.0, 12


def tones(temperature, actuators=3, taps=50):
    t = np.arange(taps) / RATE
    pitch = 300.0 * np.exp(-0.008 * np.asarray(temperature, dtype=float))[:, None, None]
    n = np.arange(actuators)[:, None]
    return np.sin(2 * np.pi * (1 + 0.4 * n) * pitch * t + n) * np.exp(-200 * t)


def networks():
    rng = np.random.default_rng(5)
    fine = np.linspace(0.0, 60.0, 25)
    shapes = rng.standard_normal((3, 7, 50)) * np.exp(-np.arange(50) / 10.0)
    return NetworkBank(InputMap.of(fine, np.sqrt(1.0 + fine)), *rng.standard_normal((2, 3, 6)), shapes)


@pytest.fixture(scope="session")
def shipments():
    """Every form of filters that can be exported."""
    several = FirBank(tones(np.arange(0.0, 61.0, 5.0)), np.arange(0.0, 61.0, 5.0), RATE, DELAY)
    single = FirBank(tones([20.0]), np.array([20.0]), RATE, DELAY)
    banks = {
        "network": FollowingBank.of_networks(networks(), RATE, DELAY),
        "cubic-spline": FollowingBank.of_filters(several),
        "cubic-spline-rigidity": FollowingBank.of_filters(several, feed=networks().input),
        "linear": FollowingBank.of_filters(several, "linear"),
        "single": FollowingBank.of_filters(single),
    }
    panel = read_panel(SECTION_2)
    made_from = provenance({"filters.h5": "0" * 64}, {"method": 'a "name" with \\ and ??( in it'})
    return {name: Shipment(bank, name, ("A1", "A2", "A3"), panel, made_from) for name, bank in banks.items()}
