"""A focusing panel with one side warmer than the other, computed as the effect ``draught_gradient`` says."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.linalg

from analysis.arrays import Complex, Real
from analysis.focusing.energy import FieldSpace
from analysis.focusing.grid import Grid
from analysis.focusing.panel import Panel
from analysis.local_laws import LocalLaws
from analysis.material import MaterialLaws
from analysis.progress import Progress
from analysis.sweep_point import SweepPoint
from app.files.bad_file import ResultFileError
from app.files.basis_cache import basis_file, cached_reduction, load_plate_basis
from app.twins.panel_twin import PanelTwin
from simulation.effects.draught_gradient import EFFECT
from simulation.reduction.basis_training import BasisTraining
from simulation.reduction.modal_form import ModalForm
from simulation.shell.assembly import assemble_chosen
from simulation.shell.fineness import Fineness
from simulation.state.plate_state import Circumstances, PlateState
from simulation.state.state_matrices import FullPlate


@dataclass(frozen=True)
class WholeLaws(LocalLaws):
    """Laws followed themselves, where their expansion would not reach across the panel."""

    laws: MaterialLaws

    @classmethod
    def about(cls, laws: MaterialLaws, temperature: float) -> "WholeLaws":
        """Take laws whose expansion about `temperature`, °C, is known as well."""
        near = laws.local(temperature)
        return cls(near.reference, near.value, near.slope, near.curvature, laws)

    def youngs_modulus(self, temperature: Any) -> Any:
        """E at `temperature` (Q,), °C, in Pa; ValueError outside the range of the laws, as of the other two."""
        return self.laws.at(temperature).youngs_modulus

    def poisson_ratio(self, temperature: Any) -> Any:
        """Poisson's ratio at `temperature` (Q,), °C."""
        return self.laws.at(temperature).poisson_ratio

    def loss_factor(self, temperature: Any) -> Any:
        """Loss factor at `temperature` (Q,), °C."""
        return self.laws.at(temperature).loss_factor


@dataclass(frozen=True)
class TiltedTwin:
    """What `analysis.compensation.tilted.TiltedModel` asks for: the full plate in a state, on the twin's vectors.

    Attributes
    ----------
    panel : Panel
    laws : MaterialLaws
        Of the panel's plate.
    full : FullPlate
    vectors : (n, r) ndarray
        Those of the uniform panel at all materials of its box, orthonormal in the mass.
    root : (r, r) ndarray
        Lower Cholesky factor of the mass, which is the identity where no shaker moves along.
    dashpots : (r, q) ndarray
    signs : (N,) ndarray
        See `PanelTwin`.
    space : FieldSpace
    """

    panel: Panel
    laws: MaterialLaws
    full: FullPlate
    vectors: Real
    root: Real
    dashpots: Real
    signs: Real
    space: FieldSpace

    def amplitudes(self, temperature: float, across: tuple[float, float], frequency: Real) -> Complex:
        """Generalised coordinates per volt or newton of every actuator.

        Parameters
        ----------
        temperature : float
            In the middle of the box around the plate, °C.
        across : (float, float)
            By how much the sides at largest x and y are warmer than those at the smallest, K.
        frequency : (F,) ndarray
            Hz.

        Returns
        -------
        (N, F, r) complex ndarray

        Raises
        ------
        ValueError
            Where a part of the plate leaves the range of the laws.
        """
        laws = WholeLaws.about(self.laws, temperature)
        plain = PlateState.baseline(*self.full.sampling, laws, temperature, frequency)
        around = Circumstances(
            frequency=frequency,
            point=SweepPoint(temperature, 0.0, 1.0),
            room_temperature=temperature,
            plate=self.panel.plate,
            strings=(),
            cables=(),
            band=(float(frequency.min()), float(frequency.max())),
            strain_energy=np.ones(frequency.size),
        )
        state = EFFECT.apply(plain, around, {"gx": across[0], "gy": across[1]})
        matrices = self.full.matrices(state, footprints=[drive.footprint for drive in self.panel.drive])
        stiffness = matrices.plate + 1j * matrices.plate_loss + matrices.patches
        reduced = self._inner(self.vectors.T @ (stiffness @ self.vectors))
        force = scipy.linalg.solve_triangular(self.root, self.vectors.T @ matrices.coupling, lower=True)
        found = ModalForm.of(0.5 * (reduced + reduced.T), self.dashpots).solve(force, frequency)
        return np.asarray(-self.signs[:, None, None] * found)

    def _inner(self, matrix: Complex) -> Complex:
        """Return L⁻¹ K L⁻ᵀ with the factor L of the mass."""
        half = scipy.linalg.solve_triangular(self.root, matrix, lower=True)
        return np.asarray(scipy.linalg.solve_triangular(self.root, half.T, lower=True))


def tilted_twin(panel: Panel, laws: MaterialLaws, report: Progress) -> TiltedTwin:
    """Reduce a panel, or find it in the cache, together with the vectors that its coordinates stand for.

    Parameters
    ----------
    laws : MaterialLaws
        Of the panel's plate.
    report : callable
        Called with a stage's name and the share of it done.

    Raises
    ------
    ResultFileError
        Where the plate cannot be reduced, or the cache holds vectors of another one.
    """
    grid, footprints = Grid.of(panel), panel.footprints
    declared = (panel.plate, panel.patch, panel.box, panel.filters.twin_band)
    choices: dict[str, Any] = {
        "footprints": footprints,
        "driven": range(len(panel.drive)),
        "attached": (),
        "points": grid.points,
        "fineness": Fineness(tolerance=panel.twin.function_tolerance),
        "training": BasisTraining(tolerance=panel.twin.basis_tolerance),
    }
    reduced = cached_reduction(*declared, **choices, progress=report)
    file = basis_file(*declared, **choices)
    basis = load_plate_basis(file)
    model = None if basis is None else assemble_chosen(*declared, basis.kept, fineness=choices["fineness"])
    if basis is None or model is None or not basis.fits(model.mass):
        raise ResultFileError(f"{file}: holds no vectors of this plate; delete it, it is then made anew")
    masses = np.array([one.mass for one in footprints])
    added = (reduced.footprints.T * masses) @ reduced.footprints if masses.any() else 0.0
    root = scipy.linalg.cholesky(np.eye(reduced.size) + added, lower=True)
    loaded = PanelTwin.of(reduced, grid, footprints, len(panel.drive))
    return TiltedTwin(
        panel, laws, FullPlate.of(model), basis.vectors, root, loaded.reduced.dashpots, loaded.signs, loaded.space
    )
