"""Filters over temperature: what they reach, and what one of them reaches everywhere (paper 5.1)."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Complex, Real
from analysis.focusing.energy import EnergyForms, FieldSpace
from analysis.focusing.fir import FirBank, FirEnergy, design, energy
from analysis.focusing.inversion import invert
from analysis.focusing.methods import Constants, Method, PanelModel, designer
from analysis.focusing.panel import Panel
from analysis.focusing.performance import contrast, spot_error
from analysis.material import MaterialLaws
from analysis.progress import Progress


@dataclass(frozen=True)
class Aim:
    """How well a set of filters focuses, over temperature and the lines of the band.

    Attributes
    ----------
    contrast : (T, F) ndarray
        Paper eq. (9), literal.
    spot_error : (T, F) ndarray
        Share of the plate's length Lx.
    """

    contrast: Real
    spot_error: Real


@dataclass(frozen=True)
class Focusing:
    """Filters at some temperatures and how they focus.

    Attributes
    ----------
    method, regularisation : str
    tolerance : float
        Of the regularisation, share of the largest singular value.
    temperature : (T,) ndarray
        Degrees Celsius.
    lines : (L,) ndarray
        Where the complex filters are given, Hz: band and tapers.
    frequency : (F,) ndarray
        Lines of the band, Hz, where contrast and spot error are given.
    filters : (T, L, N) ndarray
        Complex filters, V per unit of audio signal.
    rank : (T, L) ndarray
        Singular values of H above the tolerance.
    condition : (T, L) ndarray
        Largest over smallest singular value of H.
    bank : FirBank
        The filters cut to length.
    energy : FirEnergy
        What the cut costs.
    uncut, direct, fixed : Aim
        Reached with the complex filters, with the FIR filters of each temperature, and with the FIR
        filters of `reference_temperature` at every temperature.
    reference_temperature : float
        Degrees Celsius.
    target_share : float
        Area of the target over area of the plate: turns a literal contrast into the area-normalised one.
    """

    method: str
    regularisation: str
    tolerance: float
    temperature: Real
    lines: Real
    frequency: Real
    filters: Complex
    rank: NDArray[np.int64]
    condition: Real
    bank: FirBank
    energy: FirEnergy
    uncut: Aim
    direct: Aim
    fixed: Aim
    reference_temperature: float
    target_share: float

    @property
    def rank_changes(self) -> NDArray[np.int64]:
        """Lines of the band (T-1,) at which the rank differs between neighbouring temperatures.

        Under truncation R jumps there and no interpolation over temperature can follow it.
        """
        band = (self.lines >= self.frequency[0]) & (self.lines <= self.frequency[-1])
        changes: NDArray[np.int64] = np.count_nonzero(np.diff(self.rank[:, band], axis=0), axis=1)
        return changes


def focus(
    model: PanelModel,
    panel: Panel,
    laws: MaterialLaws,
    temperature: Real,
    method: Method = "stif",
    report: Progress = lambda _stage, _share: None,
) -> Focusing:
    """Design filters at `temperature` (T,), °C, and try those of the reference temperature at each of them."""
    settings, lines = panel.filters, panel.filters.frequency
    reference = reference_temperature(panel, laws)
    band = settings.in_band(lines)
    rule = designer(method, model, panel, lines)
    (constants, amplitude), *_ = responses(model, laws, np.array([reference]), lines)
    first = rule(constants, amplitude, model.space.forms([amplitude], panel.target.displacement))
    kept = design(first[None], np.array([reference]), settings).response(lines[band])[0]
    filters, ranks, conditions = [], [], []
    aims: dict[str, list[tuple[Real, Real]]] = {"uncut": [], "direct": [], "fixed": []}
    for t, (constants, amplitude) in enumerate(responses(model, laws, temperature, lines)):
        forms = model.space.forms([amplitude], panel.target.displacement)
        plant = invert(forms, settings.tolerance, settings.regularisation)
        here = rule(constants, amplitude, forms)
        cut = design(here[None], temperature[t : t + 1], settings).response(lines[band])[0]
        for name, tried in (("uncut", here[band]), ("direct", cut), ("fixed", kept)):
            aims[name].append(aim(model.space, forms, amplitude, band, tried))
        filters.append(here)
        ranks.append(plant.rank[0])
        conditions.append(plant.condition[0])
        report("Filters", (t + 1) / len(temperature))
    every = np.array(filters)
    return Focusing(
        method=method,
        regularisation=settings.regularisation,
        tolerance=settings.tolerance,
        temperature=temperature,
        lines=lines,
        frequency=lines[band],
        filters=every,
        rank=np.array(ranks),
        condition=np.array(conditions),
        bank=design(every, temperature, settings),
        energy=energy(every, settings),
        uncut=_joined(aims["uncut"]),
        direct=_joined(aims["direct"]),
        fixed=_joined(aims["fixed"]),
        reference_temperature=reference,
        target_share=model.space.grid.target_share,
    )


def aim(
    space: FieldSpace, forms: EnergyForms, amplitude: Complex, band: NDArray[np.bool_], filters: Complex
) -> tuple[Real, Real]:
    """Contrast and spot error (F,) of `filters` (F, N) in the `band` of one temperature's forms and amplitudes."""
    within = forms.at(slice(None), band)
    return contrast(within, filters)[0], spot_error(space, amplitude[:, band], filters)


def responses(
    model: PanelModel, laws: MaterialLaws, temperature: Real, frequency: Real
) -> Iterator[tuple[Constants, Complex]]:
    """E, nu, eta and the panel's amplitudes (N, F, r), one temperature after the other."""
    material = laws.at(temperature)
    for e, nu, eta in zip(material.youngs_modulus, material.poisson_ratio, material.loss_factor, strict=True):
        constants = (float(e), float(nu), float(eta))
        yield constants, model.amplitudes(*constants, frequency)


def covered(laws: MaterialLaws, wanted: tuple[float, float]) -> tuple[float, float]:
    """Return the part of the `wanted` range the laws cover, °C; ValueError if they do not meet."""
    low, high = max(laws.temperature_range[0], wanted[0]), min(laws.temperature_range[1], wanted[1])
    if low >= high:
        raise ValueError(
            f"the laws hold from {laws.temperature_range[0]:g} to {laws.temperature_range[1]:g} °C, the panel is "
            f"wanted from {wanted[0]:g} to {wanted[1]:g} °C: nothing in common"
        )
    return low, high


def reference_temperature(panel: Panel, laws: MaterialLaws) -> float:
    """Return the panel's reference temperature, moved to the end of the laws' range where it lies outside, °C."""
    low, high = covered(laws, panel.filters.operating_range)
    return min(max(panel.filters.reference_temperature, low), high)


def spaced(low: float, high: float, spacing: float) -> Real:
    """Temperatures every `spacing` from `low`, and `high` itself."""
    steps = np.arange(low, high + 1e-9, spacing)
    return steps if high - steps[-1] < 1e-6 * spacing else np.append(steps, high)


def _joined(rows: list[tuple[Real, Real]]) -> Aim:
    return Aim(np.array([row[0] for row in rows]), np.array([row[1] for row in rows]))
