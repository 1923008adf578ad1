"""What a comparison leaves for later stages: its sweeps, its twin, and a fit with all that was found.

Content of the twin file written by the gap stage: declaration, laws, effects and origin.
"""

from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

import analysis
from analysis.declaration.plate_material import material_box
from analysis.estimates import DeclaredQuantity
from analysis.experiment import Experiment
from analysis.gap.data.preparation import prepare
from analysis.gap.data.sweeps import GapSweeps
from analysis.gap.fitting.fit import fit_gap
from analysis.gap.fitting.gap_fit import GapFit
from analysis.gap.report import GapReport, Verdict
from analysis.recordings.frf import Frf
from analysis.recordings.frf_campaign import AnyCampaign
from analysis.twin_model import HeldEffects
from analysis.updated import Updated
from analysis.updating.corrected_twin import CorrectedTwin, material_of
from app.files.effect_cache import operators_key
from app.files.results.twin_file import (
    Basis,
    Estimated,
    TwinDeparture,
    TwinEffect,
    TwinFile,
    TwinLaws,
    TwinOrigin,
    inputs_digest,
)
from simulation.twin.effect_plate import EffectPlate
from simulation.twin.twin import Twin


@dataclass(frozen=True)
class Compared:
    """A campaign as a comparison left it.

    Attributes
    ----------
    experiment : Experiment
    frf : Frf
        As compared: drift taken out.
    twin : Twin
        With the library of effects.
    model : HeldEffects
        Around it, what the comparison held or released.
    sweeps : GapSweeps
    fit : GapFit
        With the effects found.
    """

    experiment: Experiment
    frf: Frf
    twin: Twin[EffectPlate]
    model: HeldEffects
    sweeps: GapSweeps
    fit: GapFit

    @classmethod
    def again(
        cls,
        experiment: Experiment,
        frf: Frf,
        updated: Updated,
        twin: Twin[EffectPlate],
        model: HeldEffects,
        found: GapReport,
        executor: Executor,
        twin_error: float | None = None,
    ) -> "Compared":
        """Fit the twin once more with what was found, from there: one or two linearisations.

        Parameters
        ----------
        model : HeldEffects
            As it was given to the comparison.
        executor : Executor
            Sweeps are linearised on it.
        twin_error : float, optional
            Of the twin, as carried by the comparison.
        """
        sweeps, _ = prepare(frf, experiment.protocol, updated)
        if twin_error is not None:
            sweeps = replace(sweeps, twin_error=twin_error)
        kept = {one.name for one in found.declared}
        model = model.releasing(name for name in model.tolerance_cards if name not in kept)
        fit = fit_gap(model, sweeps, found.state, tuple(found.state.effects), executor)
        return cls(experiment, frf, twin, model, sweeps, fit)


def issued_twin(
    campaign: AnyCampaign, corrected: CorrectedTwin, basis_error: float, verdict: Verdict, based_on: str | None
) -> TwinFile:
    """Return the content of the twin file; numbers to nine digits, standard deviations to four.

    Parameters
    ----------
    basis_error : float
        Certified error of the reduced model, as a share of its peak response.
    verdict : str
        As in gap.json.
    based_on : str or None
        SHA-256 of the twin file from which the comparison started.

    Raises
    ------
    ValueError
        For values that are not valid in a twin file.
    """
    experiment, found = campaign.experiment, corrected.updated
    units = [one.gain_unit for one in experiment.inputs]
    gain, *further_gain = map(_estimated, found.gains.tolist(), found.sigma_gains.tolist(), units)
    return TwinFile(
        title=experiment.title,
        plate=experiment.plate,
        patch=experiment.patch,
        drive=experiment.drive,
        sensor=experiment.sensor,
        string=experiment.string,
        cable=experiment.cable,
        acquisition=experiment.acquisition,
        protocol=experiment.protocol,
        oven=experiment.oven,
        tolerances=experiment.tolerances,
        gain=gain,
        further_gain=tuple(further_gain),
        laws=_laws(corrected),
        effect=tuple(
            TwinEffect(name=name, parameter={p.name: _estimated(p.value, p.sigma, p.unit) for p in values})
            for name, values in corrected.effects.items()
        ),
        departure=tuple(map(_departure, found.declared)),
        basis=Basis(
            operators=operators_key(experiment, material_box(experiment.plate.material)),
            error=_rounded(basis_error, 4),
        ),
        origin=TwinOrigin(
            flexura=analysis.__version__,
            campaign=campaign.name,
            inputs=inputs_digest(campaign.hashes),
            verdict=verdict,
            based_on=based_on,
        ),
    )


def _departure(one: DeclaredQuantity) -> TwinDeparture:
    return TwinDeparture(
        quantity=one.name,
        parameter=one.parameter,
        value=_rounded(one.value),
        sigma=_rounded(one.sigma, 4),
        tolerance=_rounded(one.tolerance),
        unit=one.unit,
    )


def _laws(corrected: CorrectedTwin) -> TwinLaws:
    """Return the material at the temperatures of the fit, and the range in which it holds."""
    laws, nodes = corrected.laws, corrected.nodes
    low, high = nodes.temperature[[0, -1]].tolist() if laws is None else laws.temperature_range
    material, sigma = material_of(nodes)
    return TwinLaws(
        temperature_range=(_rounded(low), _rounded(high)),
        temperature=_column(nodes.temperature),
        youngs_modulus=_column(material.youngs_modulus),
        sigma_youngs_modulus=_column(sigma.youngs_modulus, 4),
        poisson_ratio=_column(material.poisson_ratio),
        sigma_poisson_ratio=_column(sigma.poisson_ratio, 4),
        loss_factor=_column(material.loss_factor),
        sigma_loss_factor=_column(sigma.loss_factor, 4),
    )


def _estimated(value: float, sigma: float, unit: str) -> Estimated:
    return Estimated(value=_rounded(value), sigma=_rounded(sigma, 4), unit=unit)


def _column(values: NDArray[np.float64], digits: int = 9) -> tuple[float, ...]:
    return tuple(_rounded(float(value), digits) for value in values)


def _rounded(value: float, digits: int = 9) -> float:
    return float(f"{value:.{digits}g}")
