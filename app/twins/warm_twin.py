"""A focusing panel with a temperature of its own at every place, and those that a declared weather gives."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import scipy.linalg

from analysis.arrays import Complex, Real
from analysis.declaration.plate import Plate
from analysis.focusing.energy import FieldSpace, Grid
from analysis.focusing.panel import Panel
from analysis.material import MaterialLaws
from analysis.progress import Progress
from analysis.recordings.sweep_point import SweepPoint
from analysis.weather.declared_weather import Weather
from analysis.weather.family import WarmAnswer
from analysis.weather.judged import WeatherFields
from app.files.bad_file import ResultFileError
from app.files.basis_cache import basis_file, cached_reduction, load_plate_basis
from app.twins.panel_twin import PanelTwin
from simulation.effects.draught_gradient import EFFECT
from simulation.heat import PlateTemperatures, plate_temperatures
from simulation.reduction.basis_key import BasisTraining
from simulation.reduction.effect_projection import cell_centers, cell_stiffness
from simulation.reduction.modal_form import ModalForm
from simulation.shell.assembly import assemble_chosen
from simulation.shell.fineness import Fineness
from simulation.state.plate_state import Circumstances, PlateState
from simulation.state.state_matrices import FullPlate


@dataclass(frozen=True)
class WarmTwin:
    """The twin, whose cells have a temperature each.

    What `analysis.compensation.tilted.TiltedModel` and `analysis.weather.family.WarmPanel` ask for.

    Attributes
    ----------
    panel : Panel
    laws : MaterialLaws
        Of the panel's plate.
    full : FullPlate
    uniform : PanelTwin
        The panel at one temperature, in the same coordinates.
    vectors : (n, r) ndarray
        Motions of the full plate of these coordinates.
    first, second : (cells, r, r) ndarray
        See `simulation.reduction.effect_projection`.
    """

    panel: Panel
    laws: MaterialLaws
    full: FullPlate
    uniform: PanelTwin
    vectors: Real
    first: Real
    second: Real

    @property
    def space(self) -> FieldSpace:
        """The deflection shapes on the panel's grid."""
        return self.uniform.space

    @cached_property
    def points(self) -> Real:
        """Where temperatures are given, the centroids of the cells, (Q, 2), m."""
        return cell_centers(self.full.shell.space)

    def tilted(self, temperature: float, across: tuple[float, float]) -> Real:
        """Temperatures (Q,), °C, of a plate that is evenly warmer toward the largest x and y.

        Parameters
        ----------
        temperature : float
            In the middle of the box around the plate, °C.
        across : (float, float)
            By how much the sides at largest x and y are warmer than those at the smallest, K.
        """
        xi, zeta = self.panel.plate.normalised(self.points)
        plain = PlateState.baseline(xi, zeta, self.laws.local(temperature), temperature, np.ones(1))
        around = Circumstances(
            frequency=np.ones(1),
            point=SweepPoint(temperature, 0.0, 1.0),
            room_temperature=temperature,
            plate=self.panel.plate,
            strings=(),
            cables=(),
            band=self.panel.filters.band,
            strain_energy=np.ones(1),
        )
        tilted: Real = EFFECT.apply(plain, around, {"gx": across[0], "gy": across[1]}).temperature
        return tilted

    def amplitudes(self, temperature: float, across: tuple[float, float], frequency: Real) -> Complex:
        """Generalised coordinates per volt or newton of every actuator of a tilted plate, see `tilted`.

        Parameters
        ----------
        temperature : float
            °C.
        across : (float, float)
            K.
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
        return self.answer(self.tilted(temperature, across), frequency).amplitude

    def answer(self, temperature: Real, frequency: Real) -> WarmAnswer:
        """Fields and charges at a field of temperatures.

        Parameters
        ----------
        temperature : (Q,) ndarray, °C
            At `points`.
        frequency : (F,) ndarray, Hz

        Raises
        ------
        ValueError
            Where a part of the plate leaves the range of the laws.
        """
        material = self.laws.at(temperature)
        lossy = 1.0 + 1j * material.loss_factor
        c1 = lossy * material.youngs_modulus / (1.0 - material.poisson_ratio**2)
        plate = np.tensordot(c1, self.first, 1) + np.tensordot(material.poisson_ratio * c1, self.second, 1)
        reduced = self.uniform.reduced
        form = ModalForm.of(np.asarray(plate + reduced.stiffness_patch, dtype=complex), reduced.dashpots)
        found = form.solve(reduced.ports, frequency)
        charge = np.asarray(found @ reduced.ports)
        return WarmAnswer(np.asarray(-self.uniform.signs[:, None, None] * found), charge.transpose(2, 0, 1))


def warm_twin(panel: Panel, laws: MaterialLaws, report: Progress) -> WarmTwin:
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
    vectors = scipy.linalg.solve_triangular(root, basis.vectors.T, lower=True).T
    report("Cells", 0.0)
    first, second = cell_stiffness(model, vectors)
    report("Cells", 1.0)
    uniform = PanelTwin.of(reduced, grid, footprints, len(panel.drive))
    return WarmTwin(panel, laws, FullPlate.of(model), uniform, vectors, first, second)


MOMENTS_OF_WEATHER = 24
"""Between two of them a car that warms up by 70 K changes by 3 K."""


def check_thermometers(plate: Plate, weather: Weather, origin: str) -> None:
    """Raise ResultFileError for a thermometer that is off the plate; `origin` names the weather's file."""
    inside = plate.contains(np.array([one.point for one in weather.thermometer]))
    for one, on in zip(weather.thermometer, inside, strict=True):
        if not on:
            corners = [[float(f"{x:.6g}") for x in corner] for corner in plate.bounds]
            raise ResultFileError(
                f"{origin}: thermometer {one.name!r} at {list(one.point)} m is off the panel's plate, whose box "
                f"is {corners[0]} to {corners[1]} m; move it onto the plate"
            )


def temperatures(twin: WarmTwin, weather: Weather, origin: str, report: Progress) -> PlateTemperatures:
    """Solve the heat equation of a panel's plate.

    Parameters
    ----------
    origin : str
        Name of the weather's file, for messages.
    report : callable
        Called with a stage's name and the share of it done.

    Raises
    ------
    ResultFileError
        Where a part of the plate leaves the laws.
    """
    shell = twin.full.shell
    found = plate_temperatures(twin.panel.plate, shell.space.mesh, shell.thickness, weather, twin.points, report)
    low, high = twin.laws.temperature_range
    coldest, warmest = float(found.bending.min()), float(found.bending.max())
    if coldest < low - 1e-6 or warmest > high + 1e-6:
        raise ResultFileError(
            f"{origin}: it takes parts of the plate to {coldest:.1f} and {warmest:.1f} °C; the laws hold from "
            f"{low:g} to {high:g} °C: change the weather, or update a campaign that covers it"
        )
    return replace(found, bending=np.clip(found.bending, low, high))


def thermometer_places(plate: Plate, weather: Weather) -> Real:
    """Places of the thermometers, (K, 2), -1 to 1 over the box around the plate."""
    return np.stack(plate.normalised(np.array([one.point for one in weather.thermometer])), axis=1)


def weather_fields(twin: WarmTwin, weather: Weather, origin: str, report: Progress) -> WeatherFields:
    """Return the fields at `MOMENTS_OF_WEATHER` even moments and at the beginning; arguments of `temperatures`."""
    found = temperatures(twin, weather, origin, report)
    count = len(found.time)
    chosen = np.unique(np.linspace(0, count - 1, min(MOMENTS_OF_WEATHER + 1, count)).round().astype(int))
    return WeatherFields(
        found.time[chosen],
        found.bending[chosen],
        found.readings[chosen],
        thermometer_places(twin.panel.plate, weather),
        tuple(one.name for one in weather.thermometer),
    )
