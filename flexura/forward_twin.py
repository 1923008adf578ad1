"""A plate's twin as a function: material and effects in; FRFs, their derivatives, modes and matrices out."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from analysis.arrays import Complex, Real
from analysis.declaration.strict import TEMPERATURES
from analysis.effect_card import EffectCard, Parameter, Values
from analysis.experiment import Experiment
from analysis.material import LocalLaws
from analysis.recordings.frf_campaign import AnyCampaign
from analysis.recordings.sweep_point import SweepPoint
from analysis.twin_model import NO_EFFECTS, Effects, Tangent
from app.files.allowed_values import nearest
from app.files.bad_file import ResultFileError
from app.files.campaigns.kind import DECLARATION, PROTOCOL
from app.files.campaigns.loading import load_campaign
from app.files.declarations.experiment import read_declared_experiment
from app.files.declarations.plate import NAME as PLATE
from app.files.declarations.plate import declares_plate, plate_file, read_plate_measurement
from app.files.results.twin_file import TwinFile, read_twin
from app.files.settings_toml import read_table
from app.plate_frfs.given_campaign import declared_experiment
from app.stages.panel.laws import laws_of_twin
from app.twins.campaign_twin import effect_twin
from flexura.arguments import File, as_path, computing, require_range
from flexura.keywords import keyworded
from simulation.state.attached import deflection_at
from simulation.twin.effect_plate import EffectPlate
from simulation.twin.instruments import ports
from simulation.twin.loaded_modes import LoadedModes
from simulation.twin.local_solution import LocalSolution
from simulation.twin.twin import Twin

MATERIAL = ("youngs_modulus", "poisson_ratio", "loss_factor")
Material = tuple[float, float, float]
"""E [Pa], nu and eta."""


@dataclass(frozen=True)
class TwinModes:
    """Modes of a plate with its patches connected as declared.

    Attributes
    ----------
    poles : (J,) complex ndarray
        rad/s, upper half plane, by ascending magnitude.
    points : (N, 2) ndarray
        m.
    shapes : (N, J) complex ndarray
        Deflection at `points`, the largest of each mode 1.
    """

    poles: Complex
    points: Real = field(repr=False)
    shapes: Complex = field(repr=False)

    @property
    def frequency(self) -> Real:
        """Undamped natural frequencies |p| / 2 pi, (J,), Hz."""
        return np.asarray(np.abs(self.poles) / (2.0 * np.pi))

    @property
    def damping_ratio(self) -> Real:
        """-Re p / |p|, (J,)."""
        return np.asarray(-self.poles.real / np.abs(self.poles))


@dataclass(frozen=True)
class TwinMatrices:
    """A plate in reduced coordinates u, m of them: Z = K + j D + j w C - w^2 M.

    With volts V on patches and forces F along z on footprints, Z u = -coupling (V, -F). A patch gives the charge
    b'u - C V, with its column b of `coupling` and its capacitance C: shorted, V = 0; on an input with resistance R
    and capacitance Cc (open: neither), that charge is V (Cc + 1/(j w R)). The deflection of a footprint is d'u.

    Attributes
    ----------
    mass, damping, stiffness, structural_damping : (m, m) ndarray
        M, C, K and D, the last of hysteretic damping.
    coupling : (m, P + S) ndarray
        Of P patches, C per unit of u or N/V, then of S footprints of transducers.
    ports : tuple of str
        Names of its columns.
    capacitance : (P,) ndarray
        Of the patches, F.
    """

    mass: Real
    damping: Real
    stiffness: Real
    structural_damping: Real
    coupling: Real
    ports: tuple[str, ...]
    capacitance: Real


@dataclass(frozen=True)
class ForwardTwin:
    """Twin of one plate, certified inside `band` and `box`.

    Attributes
    ----------
    model : Twin
    given : TwinFile or None
        The file it comes from, whose laws, effects and departures hold unless others are named.
    """

    model: Twin[EffectPlate]
    given: TwinFile | None = None

    def __repr__(self) -> str:
        """Plate, inputs and outputs in one line."""
        low, high = self.model.band
        return f"<ForwardTwin {self.experiment.title!r}: {', '.join(self.outputs)}, {low:g} to {high:g} Hz>"

    @property
    def experiment(self) -> Experiment:
        """The declaration."""
        declared = self.model.experiment
        if declared is None:
            raise ValueError("this twin has no experiment")
        return declared

    @property
    def inputs(self) -> tuple[str, ...]:
        """Actuators, the first of which drives unless another is named."""
        return tuple(one.id for one in self.experiment.inputs)

    @property
    def outputs(self) -> tuple[str, ...]:
        """Sensors, in the order of the K rows of an FRF."""
        return tuple(one.id for one in self.experiment.outputs)

    @property
    def band(self) -> tuple[float, float]:
        """Hz."""
        return self.model.band

    @property
    def parameters(self) -> dict[str, Parameter]:
        """What may be changed beside the material, by ``effect.parameter``: declared quantities, then effects."""
        return {f"{name}.{one.name}": one for name, card in self._cards.items() for one in card.parameters}

    @property
    def _cards(self) -> Mapping[str, EffectCard]:
        return {**self.model.tolerance_cards, **self.model.cards}

    @keyworded
    def frf(
        self,
        frequency: ArrayLike,
        material: Material | None = None,
        *,
        effects: Mapping[str, Values] | None = None,
        temperature: float | None = None,
        level: float = 1.0,
        actuator: str | None = None,
    ) -> Complex:
        """FRFs of all outputs, per unit of the drive (V at the patch, or N): no amplifier's gain.

        Parameters
        ----------
        frequency : (F,) array_like, Hz
        material : (float, float, float), optional
            E [Pa], nu and eta. Left out, the laws of the twin file at `temperature`.
        effects : mapping, optional
            Values of effects and declared quantities, by name, SI; a parameter left out is absent, a shape
            typical. Those of the twin file where all are left out.
        temperature : float, optional
            Degrees Celsius; 25 for a given material.
        level : float
            Drive, V, for effects that follow it.
        actuator : str, optional
            Of `inputs`; the first where it is left out.

        Returns
        -------
        (K, F) complex ndarray

        Raises
        ------
        ValueError
            For no frequency, an unknown name, and outside the band, the material's box or a certified range.
        """
        laws, on, point = self._asked(material, effects, temperature, level, actuator)
        return self._referred(laws, on).frf(laws, _given(frequency), on, point)

    @keyworded
    def derivatives(
        self,
        frequency: ArrayLike,
        by: str | Sequence[str],
        material: Material | None = None,
        *,
        effects: Mapping[str, Values] | None = None,
        temperature: float | None = None,
        level: float = 1.0,
        actuator: str | None = None,
    ) -> tuple[Complex, Complex]:
        """FRFs as `frf`, and their derivatives: those of the reduced plate, to some 1e-4 of the largest.

        Parameters
        ----------
        frequency : (F,) array_like, Hz
        by : str or sequence of str
            ``youngs_modulus``, ``poisson_ratio``, ``loss_factor``, or names of `parameters`.
        material, effects, temperature, level, actuator
            As in `frf`.

        Returns
        -------
        (K, F) complex ndarray
        (P, K, F) complex ndarray
            Per SI unit of each.

        Raises
        ------
        ValueError
            As `frf`.
        """
        by = [by] if isinstance(by, str) else by
        laws, on, point = self._asked(material, effects, temperature, level, actuator)
        tangents = [self._tangent(name, on) for name in by if name not in MATERIAL]
        found = self._referred(laws, [*on, *(t[0] for t in tangents)]).linearise(
            laws, _given(frequency), on, point, tangents
        )
        e, eta = laws.youngs_modulus(point.temperature), laws.loss_factor(point.temperature)
        of_material = found.by_material / np.array([e, 1.0, eta])[:, None, None]
        others = iter(found.by_parameter)
        rows = [of_material[MATERIAL.index(name)] if name in MATERIAL else next(others) for name in by]
        return found.transfer, np.array(rows).reshape(len(rows), *found.transfer.shape)

    @keyworded
    def modes(
        self,
        material: Material | None = None,
        *,
        effects: Mapping[str, Values] | None = None,
        temperature: float | None = None,
        points: ArrayLike | None = None,
    ) -> TwinModes:
        """Modes inside the band, patches connected as declared.

        Parameters
        ----------
        material, effects, temperature
            As in `frf`.
        points : (N, 2) array_like, optional
            Where shapes are wanted, m; an even grid over the plate where it is left out.

        Raises
        ------
        ValueError
            As `frf`, for a point off the plate, where something is attached at a place, and where stiffness, mass
            or damping changes along the band, so that there are no modes.
        """
        solved = self._steady(material, effects, temperature)
        ops = self.model.plate.operators
        if solved.modal is None or solved.modal.count:
            raise ValueError(
                "with these effects the plate has no modes: its matrices change along the band, or it has dashpots"
            )
        wanted = ops.places if points is None else np.atleast_2d(np.asarray(points, float))
        rows = ops.place_deflection if points is None else np.array([deflection_at(ops, x, y) for x, y in wanted])
        loaded = LoadedModes.of(solved, solved.modal, self.model.instruments, self.model.plate.capacitance)
        low, high = self.band
        hertz = np.abs(loaded.poles) / (2.0 * np.pi)
        inside = (hertz >= low) & (hertz <= high)
        shapes = rows @ solved.basis @ loaded.shapes[:, inside]
        largest = shapes[np.abs(shapes).argmax(axis=0), np.arange(shapes.shape[1])]
        return TwinModes(loaded.poles[inside], wanted, shapes / largest)

    @keyworded
    def matrices(
        self,
        material: Material | None = None,
        *,
        effects: Mapping[str, Values] | None = None,
        temperature: float | None = None,
    ) -> TwinMatrices:
        """Matrices of the plate in reduced coordinates, for simulation and control elsewhere.

        Parameters
        ----------
        material, effects, temperature
            As in `frf`.

        Raises
        ------
        ValueError
            As `modes`, but for dashpots.
        """
        solved = self._steady(material, effects, temperature)
        if solved.modal is None:
            raise ValueError("with these effects the plate's matrices change along the band")
        state, local = solved.state, solved.composite
        return TwinMatrices(
            mass=local.mass,
            damping=solved.plate.dashpots(state),
            stiffness=np.asarray(state.storage[0] * local.plate + local.fixed),
            structural_damping=np.asarray(state.loss[0] * local.plate_loss),
            coupling=local.coupling,
            ports=self._ports(),
            capacitance=self.model.plate.capacitance,
        )

    def _asked(
        self,
        material: Material | None,
        effects: Mapping[str, Values] | None,
        temperature: float | None,
        level: float,
        actuator: str | None,
    ) -> tuple[LocalLaws, Effects, SweepPoint]:
        if actuator is not None and actuator not in self.inputs:
            raise ValueError(f"actuator {actuator!r} is not one of {', '.join(self.inputs)}")
        if level <= 0.0:
            raise ValueError(f"level {level:g}: an amplitude above 0 is wanted, V or N")
        if temperature is not None:
            require_range("temperature", [temperature], *TEMPERATURES, " °C")
        if material is None:
            if self.given is None or temperature is None:
                raise ValueError(
                    "material (E in Pa, nu, eta) is wanted; a twin file's laws give it at a temperature"
                )
            laws = laws_of_twin(self.given, Path(self.experiment.title)).local(temperature)
        else:
            laws = _laws_of(material, 25.0 if temperature is None else temperature)
        source = 0 if actuator is None else self.inputs.index(actuator)
        return laws, self._complete(effects), SweepPoint(laws.reference, 0.0, level, source)

    def _complete(self, effects: Mapping[str, Values] | None) -> Effects:
        """Return all parameters of the effects that are on; ValueError for one that does not exist."""
        if effects is None:
            return NO_EFFECTS if self.given is None else {**self.given.departures, **self.given.effects}
        cards, complete = self._cards, {}
        for name, values in effects.items():
            if name not in cards:
                raise ValueError(f"effect {name!r} is not known{_allowed(name, cards)}")
            known = {one.name: one for one in cards[name].parameters}
            for parameter, value in values.items():
                if parameter not in known:
                    raise ValueError(f"{name} has no parameter {parameter!r}{_allowed(parameter, known)}")
                low, high, unit = known[parameter].low, known[parameter].high, known[parameter].unit
                if not low <= value <= high:
                    raise ValueError(f"{name}.{parameter} = {value:g}; allowed: {low:g} to {high:g} {unit}")
            complete[name] = {**cards[name].zero(), **values}
        return complete

    def _tangent(self, name: str, on: Effects) -> Tangent:
        if name not in self.parameters:
            raise ValueError(f"{name!r} is no parameter{_allowed(name, (*MATERIAL, *self.parameters))}")
        effect, _, parameter = name.rpartition(".")
        return effect, parameter, on.get(effect, self._cards[effect].zero())

    def _referred(self, laws: LocalLaws, effects: Iterable[str]) -> Twin[EffectPlate]:
        return self.model.counted([laws], effects)

    def _solved(
        self, material: Material | None, effects: Mapping[str, Values] | None, temperature: float | None
    ) -> LocalSolution:
        """Solve at the edges of the band: what is alike there is alike between them."""
        laws, on, point = self._asked(material, effects, temperature, 1.0, None)
        model, lines = self._referred(laws, on), np.asarray(self.band)
        state = model.state(laws, lines, on, point)
        model.plate.require(state)
        return model.solved(state, lines)

    def _steady(
        self, material: Material | None, effects: Mapping[str, Values] | None, temperature: float | None
    ) -> LocalSolution:
        """Solve a plate to which nothing is attached but at declared points: ValueError else.

        What is attached at a place joins the plate line by line, through its give there: matrices do not hold it.
        """
        solved = self._solved(material, effects, temperature)
        if any(one.acts for one in solved.state.attached):
            raise ValueError(
                "what is attached at a place (mass_at_place, spring_at_place, ...) acts through the plate's own "
                "give there, which is no matrix: frf and derivatives have it; a point mass at a declared point "
                "has matrices and modes, too"
            )
        return solved

    def _ports(self) -> tuple[str, ...]:
        named = {port: name for name, port in ports(self.experiment).items()}
        patches = enumerate(self.experiment.patch)
        return (
            *(named.get(k, patch.id) for k, patch in patches),
            *(named[k] for k in sorted(named) if k >= len(self.experiment.patch)),
        )


def twin(
    plate: File | AnyCampaign | Experiment, *, effects: File | None = None, progress: bool | None = None
) -> ForwardTwin:
    """Return the twin of a plate as a forward model; its matrices are computed once and kept in the cache.

    Parameters
    ----------
    plate : path, campaign or Experiment
        Folder of a campaign, ``plate.toml``, an experiment's file, a twin file, or a run folder with one.
    effects : path, optional
        Folder with a user's own effects.
    progress : bool, optional
        Draw progress bars on the error stream, where that is a terminal, or in a notebook; None: in a notebook.

    Raises
    ------
    app.files.campaign_error.CampaignFileError
        With all that is wrong with the declaration or the twin file.
    ValueError
        For a user's effects that cannot be loaded.
    """
    given = None if isinstance(plate, AnyCampaign | Experiment) else _twin_file(as_path(plate))
    declared = _declared(plate) if given is None else given.experiment()
    with computing(shown=progress) as report:
        known = NO_EFFECTS if given is None else given.departures
        folder = None if effects is None else as_path(effects)
        return ForwardTwin(effect_twin(declared, report, folder, declared=known), given)


def _twin_file(path: Path) -> TwinFile | None:
    """Read the twin file at a path or in a run folder there; None where it is something else."""
    inside = path / "twin.toml"
    if inside.is_file():
        return read_twin(inside)
    if (path / "laws.h5").is_file() and not any((path / one).is_file() for one in (DECLARATION, PROTOCOL, PLATE)):
        raise ResultFileError(f"{path}: holds no twin.toml; make it with: flexura gap, or name the campaign")
    if path.suffix != ".toml" or not path.is_file():
        return None
    return read_twin(path) if str(read_table(path).get("format", "")).startswith("flexura-twin/") else None


def _declared(plate: File | AnyCampaign | Experiment) -> Experiment:
    if isinstance(plate, Experiment):
        return plate
    if isinstance(plate, AnyCampaign):
        return plate.experiment
    path = as_path(plate)
    if path.suffix == ".toml" and "oven" in read_table(path) and "cards" in read_table(path):
        found = read_declared_experiment(path)
        return found.recorded(found.sample_rate)
    return _without_frfs(path) or load_campaign(path).experiment


def _without_frfs(path: Path) -> Experiment | None:
    """Return what a ``plate.toml`` declares that names no FRFs: a twin needs none; None for anything else."""
    if not declares_plate(path):
        return None
    file = plate_file(path)
    said, rest = read_plate_measurement(file)
    if said.frf:
        return None
    if said.measurement.band is None and "protocol" not in rest:
        raise ResultFileError(f"{file}: without FRFs, give [measurement] band = [100.0, 1000.0]")
    return declared_experiment(file, said, rest, said.measurement.band or (1.0, 1000.0))


def _laws_of(material: Material, temperature: float) -> LocalLaws:
    if np.shape(material) != (3,):
        raise ValueError(f"material {material}: three numbers are wanted, E in Pa, nu and eta")
    e, nu, eta = (float(one) for one in material)
    if not (e > 0.0 and eta > 0.0 and np.isfinite([e, nu, eta]).all()):
        raise ValueError(f"material {material}: E in Pa, nu and eta are wanted, E and eta above 0")
    return LocalLaws.of_material(e, nu, eta, reference=temperature)


def _given(frequency: ArrayLike) -> ArrayLike:
    if not np.size(frequency):
        raise ValueError("no frequency is given")
    return frequency


def _allowed(name: str, known: Collection[str]) -> str:
    meant = nearest(name, known)
    return f"; {meant + ' ' if meant else ''}allowed: {', '.join(known)}"
