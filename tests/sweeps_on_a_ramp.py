"""Sweeps of a polymer plate on a ramp, every line made with the modes at the temperature when it is passed."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from analysis.experiment import Protocol
from analysis.gap.data.preparation import sweep_points
from analysis.recordings.frf import Frf
from analysis.recordings.sweep_point import SweepPoint

FREQUENCY = np.arange(100.0, 900.0)
AT_ZERO = np.array([185.0, 240.0, 310.0, 455.0, 560.0, 700.0])
OWN = np.array([0.0, -4e-4, 3e-4, -2e-4, 4e-4, 0.0])
"""Slope of each mode's own log frequency, 1/K: bending and twisting depend differently on Poisson's ratio."""
RESIDUES = 1j * np.array([[100.0, -120, 150, 130, -160, 200], [80.0, 130, -90, 150, 120, -170]])
PROTOCOL = Protocol(
    sweep="logarithmic", band=(100.0, 900.0), sweep_duration=20.0, taper=0.5, tail=2.0, repeats=2,
    ramp_rate=1.0, temperatures=tuple(np.arange(0.0, 61.0, 5.0)), directions=("up",), levels=(1.0,),
)  # fmt: skip


def modes_at(temperature: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Frequencies (..., 6), Hz, and loss factor (..., 1) of a polymer that softens by a third."""
    t = temperature[..., None]
    fall = 0.4 / (1.0 + np.exp(25.0 / 12.0)) - 0.4 / (1.0 + np.exp(-(t - 25.0) / 12.0))
    return AT_ZERO * (1.0 + fall) * np.exp(OWN * t), 0.035 + 0.03 * np.exp(-(((t - 18.0) / 18.0) ** 2))


def poles_at(temperature: NDArray[np.float64]) -> NDArray[np.complex128]:
    """Poles (..., 6), rad/s."""
    f, eta = modes_at(temperature)
    poles: NDArray[np.complex128] = 2j * np.pi * f * np.sqrt(1.0 + 1j * eta)
    return poles


def drifting(frf: Frf, points: Sequence[SweepPoint]) -> NDArray[np.complex128]:
    """FRFs (T, 2, F) without noise."""
    s, rows = 2j * np.pi * FREQUENCY[:, None], []
    for point in points:
        poles = poles_at(point.temperature + point.drift(frf.frequency))
        both = RESIDUES[:, None] / (s - poles) + RESIDUES.conj()[:, None] / (s - poles.conj())
        rows.append(both.sum(-1))
    return np.array(rows)


def on_a_ramp(protocol: Protocol = PROTOCOL, noise: float = 1e-3) -> Frf:
    """FRFs (T, 2, F) at all temperatures in all directions, with noise, a share of their rms."""
    legs = [(t, way) for way in protocol.directions for t in protocol.temperatures]
    shape = (len(legs), 2, len(FREQUENCY))
    frf = Frf(
        temperature=np.array([t for t, _ in legs]),
        direction=tuple(way for _, way in legs),
        level=np.ones(len(legs)),
        frequency=FREQUENCY,
        h=np.zeros(shape, complex),
        variance=np.ones(shape),
        coherence=np.ones(shape),
        excluded=np.zeros(len(FREQUENCY), bool),
        channels=("S1", "S2"),
    )
    clean, rng = drifting(frf, sweep_points(frf, protocol)), np.random.default_rng(3)
    deviation = noise * np.sqrt(np.mean(np.abs(clean) ** 2, axis=2, keepdims=True))
    draw = rng.normal(size=shape) + 1j * rng.normal(size=shape)
    variance = np.broadcast_to(deviation**2, shape).copy()
    return replace(frf, h=clean + deviation / np.sqrt(2) * draw, variance=variance)
