"""The plate of the simulated measurement: a twin on another mesh than the analysis's, with hidden effects."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from analysis.arrays import Real
from analysis.declaration.plate_material import material_box
from analysis.effect_card import EffectCard, Values
from analysis.experiment import Experiment
from analysis.material import MaterialLaws
from analysis.progress import Progress
from app.blind_trial.experiments import declared
from app.blind_trial.plates import OTHER_MESH
from app.blind_trial.unlisted_effects import UNLISTED_EFFECTS
from app.files.declarations.experiment import AcquiredExperiment
from app.files.declarations.simulation_section import Laws, Simulation
from app.files.effect_cache import cached_operators
from app.rig.simulated_plate import Followed, PlateTransfer, TwinPlate, TwinTransfer
from app.rig.simulated_rig import REFERENCE_TEMPERATURE, parts_around
from drivers.rig.rig import Rig
from simulation.effects.library import library
from simulation.reduction.effect_operators import EffectOperators
from simulation.twin.effect_plate import EffectPlate
from simulation.twin.twin import Twin

FOLLOWING: Mapping[str, Followed] = {
    "thermal_lag": frozenset({"rate"}),
    "annealing": frozenset({"rate"}),
    "depolarization": frozenset({"rate"}),
    "amplitude_softening": frozenset({"level"}),
    "piezo_nonlinearity": frozenset({"level"}),
}
"""Effects that depend on more than the temperature."""


class KnownTransfer(TwinTransfer):
    """Transfer with effects whose circumstances are known, so that fewer responses are computed."""

    @property
    def follows(self) -> Followed:
        """Circumstances on which any of the effects depends."""
        return frozenset().union(*(FOLLOWING.get(name, frozenset()) for name in self.effects))


@dataclass(frozen=True)
class Specimen:
    """A plate with known laws in its simulated rig.

    Attributes
    ----------
    experiments : (I,) tuple of AcquiredExperiment
        One for each input, as recorded.
    simulations : (I,) tuple of Simulation
        Laws, the same in all, gain and seed.
    twin : Twin
        With all inputs. Its library contains the project's effects and the unlisted ones.
    laws : MaterialLaws
    declared : Experiment
        As the plate is, the declaration of `twin`.
    """

    experiments: tuple[AcquiredExperiment, ...]
    simulations: tuple[Simulation, ...]
    twin: Twin[EffectPlate]
    laws: MaterialLaws
    declared: Experiment

    @classmethod
    def of(
        cls,
        experiments: Sequence[AcquiredExperiment],
        operators: EffectOperators | None = None,
        built: Sequence[AcquiredExperiment] | None = None,
    ) -> "Specimen":
        """Make the specimen of one campaign.

        Parameters
        ----------
        experiments : sequence of AcquiredExperiment
            With simulations, as of `draw_experiments`.
        operators : EffectOperators, optional
            Of `specimen_operators`, which gives them by default.
        built : sequence of AcquiredExperiment, optional
            The same with the plate as it is, where that differs from what `experiments` declare.

        Returns
        -------
        Specimen

        Raises
        ------
        ValueError
            For an experiment that simulates nothing.
        """
        real = experiments if built is None else built
        simulations = tuple(one.simulation for one in real if one.simulation is not None)
        if len(simulations) < len(experiments):
            raise ValueError("an experiment that simulates nothing has no specimen")
        recorded = declared(real)
        if operators is None:
            operators = specimen_operators(recorded)
        laws = simulations[0].laws.laws()
        known = {**library(recorded), **UNLISTED_EFFECTS}
        twin = Twin.of(recorded, EffectPlate(operators), known).referred(laws.local(REFERENCE_TEMPERATURE))
        return cls(tuple(experiments), simulations, twin, laws, recorded)

    @property
    def true_laws(self) -> Laws:
        """Laws over the plate's own temperature, as drawn; `laws` are over what the thermometer reads."""
        simulation = self.experiments[0].simulation
        if simulation is None:
            raise ValueError("an experiment that simulates nothing has no specimen")
        return simulation.laws

    @property
    def driven(self) -> Real:
        """True gains of the amplifiers, V/V, or of the exciters, N/V, (I,)."""
        pairs = zip(self.simulations, self.experiments, strict=True)
        return np.array([simulation.gain or experiment.drive_gain for simulation, experiment in pairs])

    @property
    def gains(self) -> Real:
        """True gains between what is recorded of the inputs and the inputs, (I,); 1 where a force is recorded."""
        forced = [bool(experiment.drive) for experiment in self.experiments]
        return np.where(forced, 1.0, self.driven)

    @property
    def cards(self) -> Mapping[str, EffectCard]:
        """Cards of all effects that can be hidden in it."""
        return self.twin.cards

    def transfer(self, effects: Mapping[str, Values]) -> PlateTransfer:
        """Return its transfer with `effects`."""
        return KnownTransfer(self.twin, self.laws, effects)

    def rig(self, source: int, effects: Mapping[str, Values], noise: float, file: Path) -> Rig:
        """Return the simulated rig around it.

        Parameters
        ----------
        source : int
            The input that drives.
        effects : mapping of str to Values
            Hidden effects: parameters' values by effect.
        noise : float
            On every input of the cards, V rms.
        file : Path
            The experiment's, for messages.

        Returns
        -------
        Rig
        """
        experiment = self.experiments[source]
        noisy = self.simulations[source].model_copy(update={"noise": noise})
        louder = float(self.gains[source] / self.gains[0])
        volts = np.array([response.volts for response in experiment.sensitivities.responses])
        plate = TwinPlate(
            self.transfer(effects), float(self.driven[source]), sensitivity=volts, source=source, louder=louder
        )
        return parts_around(experiment, noisy, plate, file).rig()


def specimen_operators(experiment: Experiment, report: Progress | None = None) -> EffectOperators:
    """Operators on the trial's own mesh, taken from the cache or computed and stored there.

    Parameters
    ----------
    experiment : Experiment
    report : callable, optional
        Called with the stage's name and the share done.

    Returns
    -------
    EffectOperators
    """
    silent: Progress = report or (lambda stage, share: None)
    box = material_box(experiment.plate.material)
    return cached_operators(experiment, box, silent, OTHER_MESH, exact=True)
