"""What a comparison leaves for later stages: its sweeps, its twin, and a fit with all that was found."""

from concurrent.futures import Executor
from dataclasses import dataclass, replace

from analysis.experiment import Experiment
from analysis.gap.data.preparation import prepare
from analysis.gap.data.sweeps import GapSweeps
from analysis.gap.fitting.fit import fit_gap
from analysis.gap.fitting.gap_fit import GapFit
from analysis.gap.report import GapReport
from analysis.held_effects import HeldEffects
from analysis.recordings.frf import Frf
from analysis.updated import Updated
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
