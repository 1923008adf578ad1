"""A twin small enough to be written down: modes whose stiffness is affine in C1 = E/(1-nu^2) and C2 = nu C1."""

from collections.abc import Iterable
from typing import Self

import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.effect_card import EffectCard
from analysis.material import LocalLaws, MaterialBox
from analysis.recordings.frf import Frf
from analysis.recordings.sweep_point import SweepPoint
from analysis.twin_model import Linearisation


class AffineModes:
    """Diagonal twin: k_j = (1 + j eta)(C1 a_j + C2 b_j) + p_j, unit modal masses, K sensors."""

    box = MaterialBox((0.8e9, 4e9), (0.3, 0.48), (0.01, 0.12))

    def __init__(self, rng: np.random.Generator, modes: int = 12, sensors: int = 1) -> None:
        # torsion-like modes feel C1 - C2, bending-like ones C1 alone
        squared = (2 * np.pi * np.geomspace(70.0, 1700.0, modes)) ** 2
        share = rng.uniform(-0.9, 0.3, modes)
        self.a = squared / 2.5e9
        self.b = share * self.a
        self.p = 0.03 * squared
        self.residues = rng.uniform(0.5, 1.5, (sensors, modes)) * rng.choice([-1, 1], (sensors, modes)) * 1e4

    @property
    def tolerance_cards(self) -> dict[str, EffectCard]:
        return {}

    @property
    def cards(self) -> dict[str, EffectCard]:
        return {}

    def counted(self, *_: object) -> Self:
        return self

    def sensitivities(
        self, e: float, nu: float, eta: float, frequency: NDArray[np.float64], source: int = 0
    ) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
        c1 = e / (1 - nu**2)
        plate = c1 * (self.a + nu * self.b)
        omega2 = (2 * np.pi * frequency)[:, None] ** 2
        z = (1 + 1j * eta) * plate + self.p - omega2
        slope_nu = c1 * (2 * nu / (1 - nu**2) * (self.a + nu * self.b) + self.b)
        slopes = [(1 + 1j * eta) * plate / e, (1 + 1j * eta) * slope_nu, 1j * plate]
        residues = np.roll(self.residues, 3 * source, axis=1)  # another place drives the same modes
        h = residues @ (1 / z).T
        return h, np.array([residues @ (-slope / z**2).T for slope in slopes])

    def frf(self, laws: LocalLaws, frequency: NDArray[np.float64], *rest: object) -> NDArray[np.complex128]:
        return self.linearise(laws, frequency, *rest).transfer

    def linearise(self, laws: LocalLaws, frequency: NDArray[np.float64], *rest: object) -> Linearisation:
        point = next((one for one in rest if isinstance(one, SweepPoint)), SweepPoint(20.0, 0.0, 1.0))
        e, nu, eta = np.exp(laws.value[0]), laws.value[1], np.exp(laws.value[2])
        transfer, slopes = self.sensitivities(e, nu, eta, frequency, point.source)
        nothing = np.zeros((0, *transfer.shape), complex)
        by_material = slopes * np.array([e, 1.0, eta])[:, None, None]
        by_temperature = np.tensordot(laws.rates(laws.reference), by_material, 1)
        transfer = transfer + point.drift(frequency) * by_temperature
        return Linearisation(transfer, by_material, 0.0 * by_material, 0.0 * by_material, by_temperature, nothing)

    def measured(
        self,
        temperature: NDArray[np.float64],
        constants: Iterable[tuple[float, float, float]],
        gain: float,
        rng: np.random.Generator,
        noise: float = 0.01,
        source: int = 0,
    ) -> Frf:
        """One sweep at each temperature, with white noise of a share of its rms."""
        frequency, point = np.arange(100.0, 1500.0, 1.0), SweepPoint(20.0, 0.0, 1.0, source)
        clean = gain * np.array([self.frf(LocalLaws.of_material(*row), frequency, point) for row in constants])
        variance = np.full(clean.shape, noise**2) * (np.abs(clean) ** 2).mean((1, 2), keepdims=True)
        error = rng.standard_normal((2, *clean.shape)) * np.sqrt(variance / 2)
        return Frf(
            temperature=temperature,
            direction=("up",) * len(temperature),
            level=np.ones(len(temperature)),
            frequency=frequency,
            h=clean + error[0] + 1j * error[1],
            variance=variance,
            coherence=np.ones(clean.shape),
            excluded=np.zeros(len(frequency), dtype=bool),
            channels=tuple(f"S{k + 1}" for k in range(len(self.residues))),
        )


@pytest.fixture
def twin() -> AffineModes:
    return AffineModes(np.random.default_rng(7))


@pytest.fixture(scope="session")
def affine_modes() -> type[AffineModes]:
    return AffineModes
