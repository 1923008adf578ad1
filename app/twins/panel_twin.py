"""A focusing panel joined to its reduced twin."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any, Self

import numpy as np

from analysis.arrays import Complex, Real
from analysis.channel import Footprint
from analysis.focusing.energy import EnergyForms, FieldSpace, Grid
from analysis.focusing.panel import Panel
from analysis.focusing.panel_model import Constants, PanelModes
from analysis.material import MaterialLaws
from analysis.progress import Progress
from app.files.bad_file import ResultFileError
from app.files.basis_cache import basis_file, cached_reduction
from simulation.reduction.basis_key import BasisTraining
from simulation.reduction.damped_modes import EnergySums
from simulation.reduction.modal_form import ModalForm
from simulation.reduction.reduced_model import ReducedModel, lowest_modes
from simulation.shell.fineness import Fineness


@dataclass(frozen=True)
class PanelTwin:
    """What `analysis.focusing.panel_model.PanelModel` asks for, answered by a reduced twin.

    Attributes
    ----------
    reduced : ReducedModel
        With the deflection at the grid's points, and forces as its only footprints.
    space : FieldSpace
    signs : (N,) ndarray
        Of the actuators: patches 1, forces what `ReducedModel.amplitudes` takes for positive.
    """

    reduced: ReducedModel
    space: FieldSpace
    signs: Real

    @classmethod
    def of(cls, reduced: ReducedModel, grid: Grid, footprints: Sequence[Footprint] = (), forces: int = 0) -> Self:
        """Compute a reduced model's shapes on a grid; the masses of the footprints move with the plate.

        Parameters
        ----------
        footprints : sequence of Footprint
            All of the model.
        forces : int
            How many of them, from the first on, are driven.
        """
        loaded = reduced.loaded(np.array([one.mass for one in footprints]))
        loaded = replace(loaded, footprints=loaded.footprints[:forces])
        signs = np.array([1.0] * reduced.capacitance.size + [-one.along for one in footprints[:forces]])
        return cls(loaded, FieldSpace.of(loaded.deflection, grid), signs)

    def amplitudes(
        self, youngs_modulus: float, poisson_ratio: float, loss_factor: float, frequency: Real
    ) -> Complex:
        """Generalised coordinates per volt or newton of every actuator.

        Parameters
        ----------
        youngs_modulus : float
            Pa.
        frequency : (F,) ndarray
            Hz.

        Returns
        -------
        (N, F, r) complex ndarray
        """
        constants = (youngs_modulus, poisson_ratio, loss_factor)
        self.reduced.require(*constants, frequency)
        return self._modal_form(*constants).solve(-self.reduced.ports * self.signs, frequency)

    def forms(
        self,
        youngs_modulus: float,
        poisson_ratio: float,
        loss_factor: float,
        frequency: Real,
        displacement: float = 1.0,
    ) -> EnergyForms:
        """Energy forms of these fields, as sums over the poles; with dashpots, of the fields themselves.

        Parameters
        ----------
        youngs_modulus : float
            Pa.
        frequency : (F,) ndarray
            Hz.
        displacement : float
            What the target is asked for, m per unit of audio signal.

        Returns
        -------
        EnergyForms
            Of one material.
        """
        reduced, space, constants = self.reduced, self.space, (youngs_modulus, poisson_ratio, loss_factor)
        if reduced.dashpots.shape[1]:
            return space.forms([self.amplitudes(*constants, frequency)], displacement)
        reduced.require(*constants, frequency)
        sums = EnergySums.of(self._modal_form(*constants), -reduced.ports * self.signs, frequency)
        plate, target = sums.energy(space.plate), sums.energy(space.target)
        return EnergyForms(plate[None], target[None], displacement * sums.along(space.aim)[None])

    @cached_property
    def _modal_form(self) -> Callable[[float, float, float], ModalForm]:
        """`ReducedModel.modal_form`, the last ones kept: fields and energies are asked for one after the other."""
        return lru_cache(maxsize=16)(self.reduced.modal_form)

    def restricted(self, basis: Real) -> Self:
        """Return the twin on the columns of `basis` (r, s), orthonormal."""
        return type(self)(self.reduced.restricted(basis), self.space.restricted(basis), self.signs)

    def modes(self, youngs_modulus: float, poisson_ratio: float, loss_factor: float, count: int) -> PanelModes:
        """Lowest `count` undamped modes, each with the damping the plate gives it (patches add none).

        Parameters
        ----------
        youngs_modulus : float
            Pa.
        """
        values, shapes = lowest_modes(self.reduced, youngs_modulus, poisson_ratio, loss_factor, count)
        return PanelModes(values, shapes, -shapes.T @ (self.reduced.ports * self.signs))


def panel_twin(panel: Panel, laws: MaterialLaws, report: Progress) -> PanelTwin:
    """Assemble and reduce the twin of a panel, or find it in the cache.

    `laws` say which materials it will be asked about.

    Parameters
    ----------
    laws : MaterialLaws
        The materials the twin will be asked about.
    report : callable
        Called with a stage's name and the share of it done.

    Raises
    ------
    ResultFileError
        Where the laws leave the panel's twin box.
    """
    grid = Grid.of(panel)
    box = panel.box
    ranges = {
        "youngs_modulus": box.youngs_modulus,
        "poisson_ratio": box.poisson_ratio,
        "loss_factor": box.loss_factor,
    }
    left = [
        f"{key} of the laws is {min(values):.4g} to {max(values):.4g}, [twin] has [{low:g}, {high:g}]"
        for values, (key, (low, high)) in zip(zip(*_materials(laws), strict=True), ranges.items(), strict=True)
        if min(values) < low or max(values) > high
    ]
    if left:
        raise ResultFileError(
            f"{panel.title}: outside the panel's twin: {'; '.join(left)}; widen [twin] in the panel's "
            "file. The paper's panel (the one without --panel) is of plastic: for another material "
            "flexura new panel, then --panel"
        )
    return PanelTwin.of(panel_reduction(panel, grid, report), grid, panel.footprints, len(panel.drive))


def panel_reduction(panel: Panel, grid: Grid, report: Progress) -> ReducedModel:
    """Reduced model of a panel, known on its grid, from the cache or made; whatever the laws are.

    Parameters
    ----------
    grid : Grid
        The panel's.
    report : callable
        Called with a stage's name and the share of it done.

    Raises
    ------
    ResultFileError
        Where the panel cannot be reduced.
    """
    return cached_reduction(**_asked(panel, grid), progress=report)


def panel_is_reduced(panel: Panel) -> bool:
    """Whether `panel_reduction` would find the model in the cache."""
    return basis_file(**_asked(panel, Grid.of(panel))).is_file()


def _asked(panel: Panel, grid: Grid) -> dict[str, Any]:
    """Return what is asked of a panel's reduced model."""
    return {
        "plate": panel.plate,
        "patches": panel.patch,
        "box": panel.box,
        "band": panel.filters.twin_band,
        "footprints": panel.footprints,
        "driven": range(len(panel.drive)),
        "points": grid.points,
        "fineness": Fineness(tolerance=panel.twin.function_tolerance),
        "training": BasisTraining(tolerance=panel.twin.basis_tolerance),
    }


def _materials(laws: MaterialLaws) -> list[Constants]:
    law = laws.at(np.linspace(*laws.temperature_range, 241))
    rows = zip(law.youngs_modulus, law.poisson_ratio, law.loss_factor, strict=True)
    return [(float(e), float(nu), float(eta)) for e, nu, eta in rows]
