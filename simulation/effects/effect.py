"""A physical effect: its card, and the change that it makes to the state of a plate."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from analysis.effect_card import EffectCard
from analysis.experiment import Experiment
from simulation.state.plate_state import Circumstances, PlateState

Apply = Callable[[PlateState, Circumstances, Mapping[str, Any]], PlateState]


def always(experiment: Experiment) -> bool:
    """Return True: the effect is possible in any campaign."""
    return True


def isotropic(experiment: Experiment) -> bool:
    """Whether the sheet is not declared by direction: then its moduli and losses are fitted in any case."""
    material = experiment.plate.material
    return material is None or material.departure is None


@dataclass(frozen=True)
class Effect:
    """One entry of the library.

    Attributes
    ----------
    card : callable
        Experiment -> EffectCard: ranges and sites may depend on the plate.
    apply : callable
        (state, circumstances, values by parameter) -> state. Values may be complex, see
        `simulation.state.plate_state`.
    available : callable
        Experiment -> bool: whether the declaration is sufficient (a point mass needs its point).
    wants : str
        Object of "declare": what the declaration lacks where the effect is not possible, for messages.
    nothing_missing : bool
        Whether nothing is missing where it is not possible: it is about instruments that a rig lacks, or about
        what is fitted in any case.
    needs_strain_energy : bool
        Whether `apply` looks at `Circumstances.strain_energy`: it is found so that the plate that `apply` makes of
        it has it. Each line of a spectrum may follow the energy of that line; nothing else may follow any.
    """

    card: Callable[[Experiment], EffectCard]
    apply: Apply
    available: Callable[[Experiment], bool] = always
    wants: str = ""
    nothing_missing: bool = False
    needs_strain_energy: bool = False
