"""Trial of an alternative declaration: how many modes of one sweep a coarse model has where and as they are.

The modulus is found by `analysis.updating.start`'s comparison of levels; around the best the modes are
paired. Gain and the sign of every channel are free: what is tried is where resonances lie and which of them a
channel sees.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Complex, Real
from analysis.identification.lines import Lines
from analysis.identification.pole_residue import ResidualTerms
from analysis.identification.pole_search import project
from analysis.material import MaterialBox
from analysis.pairing.assignment import ModeList, ModePairs, pair_modes
from analysis.updating.start import STEP, levels, scan_grid, smoothed

MIDDLE, OTHERS = 0.5, (0.15, 0.85)
"""Places in the box of the Poisson's ratio that is scanned, and of those tried at the best moduli."""
BEST = 2
"""Moduli of best levels about which modes are paired."""
FINE_STEP = 0.015
"""Step of log E there: shifts frequencies by less than the inner half of the window for pairs."""
BEYOND = 0.3
"""Share of the band's edges up to which modes outside it have residues of their own."""


class PairingModel(Protocol):
    """Model of an alternative, as a trial needs it."""

    def frf(
        self, youngs_modulus: float, poisson_ratio: float, frequency: Real, loss_factor: float = ...
    ) -> Complex:
        """Transfer to all channels.

        Parameters
        ----------
        youngs_modulus : float
            Pa.
        poisson_ratio : float
        frequency : (F,) ndarray
            Hz.
        loss_factor : float

        Returns
        -------
        (K, F) complex ndarray
        """
        ...

    def poles(self, youngs_modulus: float, poisson_ratio: float, loss_factor: float = ...) -> Complex:
        """Poles of the plate.

        Parameters
        ----------
        youngs_modulus : float
            Pa.
        poisson_ratio : float
        loss_factor : float

        Returns
        -------
        (r,) complex ndarray
            rad/s, ascending.
        """
        ...


@dataclass(frozen=True)
class SweepModes:
    """One sweep with its modes.

    Attributes
    ----------
    temperature : float
        Degrees Celsius.
    frequency : (F,) ndarray
        Hz.
    h : (K, F) complex ndarray
    deviation : (K, F) ndarray
    modes : ModeList
    terms : ResidualTerms
    """

    temperature: float
    frequency: Real
    h: Complex
    deviation: Real
    modes: ModeList
    terms: ResidualTerms

    @property
    def rms(self) -> Real:
        """Of every channel, (K,)."""
        return np.asarray(np.sqrt((np.abs(self.h) ** 2).mean(axis=1)))

    @property
    def loss_factor(self) -> float:
        """Median of the modes'."""
        return float(2.0 * np.median(self.modes.damping_ratio))


@dataclass(frozen=True)
class CoarseTrial:
    """Best pairing of an alternative, and its modulus, Pa."""

    pairs: ModePairs
    youngs_modulus: float

    @property
    def share(self) -> float:
        """Share of the strong measured modes that it has; 0 where no mode is strong."""
        return float(np.nan_to_num(self.pairs.share))


def tried(model: PairingModel, box: MaterialBox, sweep: SweepModes) -> CoarseTrial:
    """Pair the modes of a sweep with those of a model, at the material in a box at which most of them pair.

    Parameters
    ----------
    model : PairingModel
    box : MaterialBox
    sweep : SweepModes

    Returns
    -------
    CoarseTrial
    """
    trials = [
        CoarseTrial(_paired(model, e, nu, sweep), e)
        for modulus, nu in _best_levels(model, box, sweep)
        for e in _around(modulus, box)
    ]
    return max(trials, key=lambda one: (one.share, -float(one.pairs.distance.sum())))


def _around(modulus: float, box: MaterialBox) -> Iterator[float]:
    count = int(np.ceil(STEP / FINE_STEP))
    for step in range(-count, count + 1):
        yield float(np.clip(modulus * np.exp(step * FINE_STEP), *box.youngs_modulus))


def scanned_materials(box: MaterialBox) -> list[tuple[float, float]]:
    """E [Pa] over a box, in steps that shift resonances by less than a window of levels, and the middle nu."""
    low, high = box.youngs_modulus
    moduli = np.geomspace(low, high, int(np.ceil(np.log(high / low) / STEP)) + 1).tolist()
    return [(e, _ratio(box, MIDDLE)) for e in moduli]


def _ratio(box: MaterialBox, share: float) -> float:
    low, high = box.poisson_ratio
    return low + share * (high - low)


def _best_levels(model: PairingModel, box: MaterialBox, sweep: SweepModes) -> list[tuple[float, float]]:
    """Return E [Pa] and nu of best agreement in levels, best first, at `BEST` moduli."""
    grid = scan_grid(sweep.frequency)
    seen = levels(smoothed(np.abs(sweep.h) ** 2, sweep.frequency, grid))

    def agreement(material: tuple[float, float]) -> float:
        power = np.abs(model.frf(*material, grid, sweep.loss_factor)) ** 2
        return float((seen * levels(smoothed(power, grid, grid))).mean())

    first = sorted(scanned_materials(box), key=agreement)[-BEST:]
    return [max([(e, _ratio(box, share)) for share in (MIDDLE, *OTHERS)], key=agreement) for e, _ in first]


def _paired(model: PairingModel, modulus: float, ratio: float, sweep: SweepModes) -> ModePairs:
    h = model.frf(modulus, ratio, sweep.frequency, sweep.loss_factor)
    sign = np.where((h.conj() * sweep.h).real.sum(axis=1) < 0.0, -1.0, 1.0)[:, None]
    h = h * sign * np.sqrt((np.abs(sweep.h) ** 2).sum() / (np.abs(h) ** 2).sum())
    poles = _near(model.poles(modulus, ratio, sweep.loss_factor), sweep.frequency)
    residues = project(Lines(sweep.frequency, h, sweep.deviation), poles, sweep.terms, derivatives=False).residues
    band = (float(sweep.frequency[0]), float(sweep.frequency[-1]))
    return pair_modes(sweep.temperature, band, sweep.modes, ModeList.computed(poles, residues, sweep.rms))


def _near(poles: NDArray[np.complex128], frequency: Real) -> NDArray[np.complex128]:
    f = np.abs(poles) / (2.0 * np.pi)
    return np.asarray(poles[(f > (1.0 - BEYOND) * frequency[0]) & (f < (1.0 + BEYOND) * frequency[-1])])
