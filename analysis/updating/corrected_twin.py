"""The twin with its effects: laws fitted again, and its FRF for every sweep of a campaign."""

from collections.abc import Mapping
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from itertools import count

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Complex
from analysis.estimates import DeclaredQuantity, Estimate, FittedLaws
from analysis.experiment import Protocol
from analysis.gap.data.groups import FEWEST, LawSmoothness, TemperatureGroups, distinct_temperatures, mean_laws
from analysis.gap.data.noise import NumericalFloor
from analysis.gap.data.preparation import prepare, sweep_points
from analysis.gap.fitting.fit import fit_gap
from analysis.gap.fitting.gap_fit import fitted_sheet
from analysis.gap.fitting.state import GapState, starting_state
from analysis.material import Material, MaterialLaws, MaterialSigma
from analysis.recordings.frf import Frf
from analysis.recordings.sweep_point import SweepPoint
from analysis.twin_model import TwinModel
from analysis.updated import Updated
from analysis.updating.laws import fit_laws, reached


@dataclass(frozen=True)
class CorrectedTwin:
    """Laws and FRFs of a twin with known effects.

    Attributes
    ----------
    effects : mapping of str to tuple of Estimate
        All effects that are on.
    nodes : FittedLaws
        E, nu and eta at the campaign's temperatures.
    laws : MaterialLaws or None
        Smooth laws through `nodes`; None for fewer than three temperatures.
    updated : Updated
        The same per sweep, with misfits.
    frequency : (F,) ndarray
        Hz.
    answers : (T, K, F) complex ndarray
        FRFs of the twin for every sweep, gain included, V/V.
    """

    effects: Mapping[str, tuple[Estimate, ...]]
    nodes: FittedLaws
    laws: MaterialLaws | None
    updated: Updated
    frequency: NDArray[np.float64]
    answers: NDArray[np.complex128]


@dataclass(frozen=True)
class FittedTwin:
    """Result of a fit of laws and gain with effects.

    Attributes
    ----------
    state : GapState
    laws : FittedLaws
    sigma_gain : (I,) ndarray
        Of every input's gain, V/V.
    effects : mapping of str to tuple of Estimate
        Fitted and held.
    declared : tuple of DeclaredQuantity
        What is declared with a tolerance.
    """

    state: GapState
    laws: FittedLaws
    sigma_gain: NDArray[np.float64]
    effects: Mapping[str, tuple[Estimate, ...]]
    declared: tuple[DeclaredQuantity, ...] = ()


def fit_twin(
    frf: Frf,
    plain: Updated,
    model: TwinModel,
    protocol: Protocol,
    executor: Executor,
    effects: Mapping[str, tuple[Estimate, ...]],
    *,
    floor: NumericalFloor | None = None,
) -> FittedTwin:
    """Fit laws and gains to all sweeps; the effects are held.

    Parameters
    ----------
    plain : Updated
        Model updating without effects, from which the fit starts.
    model : TwinModel
        Holds the effects.
    protocol : Protocol
        Gives the ramp rate.
    executor : Executor
        Sweeps are linearised on it.
    effects : mapping of str to tuple of Estimate
        Those that are held.
    floor : NumericalFloor, optional
        Discretisation error of the twin; that of a converged twin by default.

    Raises
    ------
    ValueError
        As `analysis.gap.data.preparation.prepare`.
    """
    sweeps, _ = prepare(frf, protocol, plain, floor=floor)
    fit = fit_gap(model, sweeps, starting_state(plain, sweeps.groups), (), executor)
    gain = np.exp(fit.state.log_gain)
    sheet = fitted_sheet(None if plain.sheet is None else plain.sheet.declared, fit)
    laws = replace(fit.fitted_laws(sweeps.groups.reference), sheet=sheet)
    declared = fit.declared_quantities(model.tolerance_cards)
    return FittedTwin(fit.state, laws, gain * fit.stated.log_gain, effects, declared)


def corrected_twin(
    frf: Frf, plain: Updated, model: TwinModel, protocol: Protocol, fitted: FittedTwin, executor: Executor
) -> CorrectedTwin:
    """Compute laws and FRFs of a fitted twin.

    Parameters
    ----------
    plain : Updated
        Model updating of the same sweeps without effects: gives the misfits before; its correlations are kept,
        because they depend only on the twin's sensitivities.
    model : TwinModel
        The twin; it holds the effects that are not in the state.
    protocol : Protocol
        Gives the ramp rate.
    executor : Executor
        Sweeps are computed on it.
    """
    groups = TemperatureGroups.of(frf.temperature)
    local = LawSmoothness.of(groups.reference, mean_laws(plain.material, groups)).laws(fitted.state.laws)
    model = model.counted(local, fitted.state.on)
    gain = np.exp(fitted.state.log_gain)

    def answered(sweep: int, read: SweepPoint) -> tuple[Complex, list[float]]:
        group, reading = groups.of_sweep[sweep], read.temperature
        point = fitted.state.circumstances(sweep, read)
        laws = local[group].tilted(fitted.state.tilt[group], fitted.state.bend[group], point.temperature)
        answer = gain[point.source] * model.frf(laws, frf.frequency, fitted.state.on, point)
        return answer, [laws.youngs_modulus(reading), laws.poisson_ratio(reading), laws.loss_factor(reading)]

    made = list(executor.map(answered, count(), sweep_points(frf, protocol)))
    h, material = np.array([one for one, _ in made]), np.array([one for _, one in made], dtype=float)
    return CorrectedTwin(
        effects=fitted.effects,
        nodes=fitted.laws,
        laws=smooth_laws(fitted.laws, reached(protocol, fitted.laws.temperature)),
        updated=_updated(frf, plain, model, groups, fitted, material, h),
        frequency=frf.frequency,
        answers=h,
    )


def _updated(
    frf: Frf,
    plain: Updated,
    model: TwinModel,
    groups: TemperatureGroups,
    fitted: FittedTwin,
    material: NDArray[np.float64],
    answers: NDArray[np.complex128],
) -> Updated:
    """Rows per sweep, as model updating gives them."""
    used = ~frf.excluded
    rest = np.abs(frf.h - answers)[:, :, used] ** 2
    sigma = fitted.laws.sigma[groups.of_sweep]
    gains = np.stack([np.exp(fitted.state.log_gain), fitted.sigma_gain], axis=1)
    sheet, (e, nu, eta) = fitted.laws.sheet, material.T
    logs = np.stack([np.log(e), nu, np.log(eta)], axis=1)
    return Updated(
        temperature=frf.temperature,
        material=Material(*material.T),
        sigma=Material(*material.T).sigma(sigma),
        correlation=plain.correlation,
        gain=float(gains[0, 0]),
        sigma_gain=float(gains[0, 1]),
        misfit_start=plain.misfit,
        misfit=np.sqrt(rest.sum((1, 2)) / (np.abs(frf.h[:, :, used]) ** 2).sum((1, 2))),
        noise_floor=frf.noise_floor,
        chi2_per_dof=(rest / frf.variance[:, :, used]).mean((1, 2)),
        settled=model.box.inside(material),
        further=gains[1:] if len(gains) > 1 else None,
        declared=fitted.declared,
        common=None if fitted.laws.common is None else fitted.laws.common[groups.of_sweep],
        sheet=None if sheet is None else sheet.at(logs, groups.of_sweep),
    )


def smooth_laws(nodes: FittedLaws, temperature_range: tuple[float, float]) -> MaterialLaws | None:
    """Smooth laws through the nodes; None for fewer than three temperatures.

    Parameters
    ----------
    temperature_range : (float, float)
        Where they are to hold, degrees Celsius, as `analysis.updating.laws.fit_laws`.
    """
    temperature, material = nodes.temperature, material_of(nodes)[0]
    if distinct_temperatures(temperature) < FEWEST:
        return None
    # what the temperatures share widens the bands: taken for noise, a smooth law would average it away
    own = material.sigma(nodes.own_sigma)
    return fit_laws(temperature, material, own, temperature_range=temperature_range, common=nodes.shared)


def material_of(nodes: FittedLaws) -> tuple[Material, MaterialSigma]:
    """E, nu and eta at the nodes, and their standard deviations."""
    material = Material(np.exp(nodes.value[:, 0]), nodes.value[:, 1], np.exp(nodes.value[:, 2]))
    return material, material.sigma(nodes.sigma)
