"""The simulated rig: cards and oven around the twin, as ``[simulation]`` of the experiment declares them.

Its plate in its oven follows the heat equation. A plate in air that warms by r K/s comes, after its time constant,
to T = air + r b(x, y) with G b = -C 1: b is negative, its mean is the lag that a sensor on the plate sees, and
what differs from the mean is a gradient. Both have one cause, the heat that has to pass from the air into the
plate.
"""

import dataclasses
import math
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.polynomial.legendre import legvander2d

from analysis.arrays import Numbers, Real
from analysis.declaration.plate import Plate
from analysis.declaration.plate_material import material_box
from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from analysis.material import MaterialLaws
from analysis.progress import Progress
from analysis.recordings.sweep_point import SweepPoint
from analysis.twin_model import Effects
from app.files.campaign_error import CampaignFileError, Problem
from app.files.declarations.experiment import AcquiredExperiment
from app.files.declarations.hidden_effects import with_shapes
from app.files.declarations.simulation_section import HeatInOven, Simulation
from app.rig.simulated_plate import PlateTransfer, TwinPlate, TwinTransfer
from app.twins.campaign_twin import OFFSET, campaign_twin, effect_twin
from drivers.ni.modules import KNOWN, KNOWN_OUTPUTS, NI_9211, NI_9213, InputModule
from drivers.ni.simulated.surroundings import DrivenPlate, Module
from drivers.ni.wiring import Wiring
from drivers.ovens.simulated.regulated_oven import Chamber
from drivers.rig.simulated import SimulatedParts, simulated_parts
from drivers.soundcard.card import SoundCard
from simulation.effects.effect import Effect
from simulation.heat import HeatModel, settled
from simulation.shell.shell_plate import ShellPlate
from simulation.state.plate_state import Circumstances, PlateState
from simulation.twin.effect_plate import EffectPlate
from simulation.twin.twin import Twin

REFERENCE_TEMPERATURE = 25.0
"""Degrees Celsius at which `Twin.referred` counts strain energies."""


def _simulation(experiment: AcquiredExperiment, file: Path) -> Simulation:
    if experiment.simulation is None:
        allowed = "a table that declares what is simulated: laws, seed, gain, noise"
        raise CampaignFileError(file.parent, [Problem(file.name, "simulation", "nothing", allowed)])
    return experiment.simulation


NAME = "uneven_heat"
"""Of the gradient as an effect of the simulated plate; no library that a campaign is held against has it."""
POLYNOMIAL_DEGREE = 6
"""Of the polynomials in the place that b is fitted by, in each direction."""


@dataclass(frozen=True)
class PlateBehindAir:
    """How far a plate is behind the air on a ramp.

    Attributes
    ----------
    lag : float
        Mean over the plate, s.
    capacity : float
        J/K.
    coefficients : (`POLYNOMIAL_DEGREE` + 1, `POLYNOMIAL_DEGREE` + 1) ndarray
        Of Legendre products in xi and zeta: b as bending weighs it over the thickness, less its mean, K per K/s.
    """

    lag: float
    capacity: float
    coefficients: Real

    @classmethod
    def of(cls, experiment: Experiment, heat: HeatInOven) -> "PlateBehindAir":
        """Solve for a plate."""
        plate = experiment.plate
        shell = ShellPlate.of(plate, experiment.patch, degree=2)
        xi, zeta = plate.normalised(shell.space.points)
        transfer = heat.convection * (1.0 + 0.5 * (heat.uneven[0] * xi + heat.uneven[1] * zeta))
        model = HeatModel.of(
            shell.space,
            shell.thickness,
            density=plate.density,
            specific_heat=heat.specific_heat,
            conductivity=heat.conductivity,
            front=transfer,
            back=transfer,
        )
        behind = settled(model, -(model.capacity @ model.uniform(1.0)))
        field = model.seen(behind, "bending")
        capacity = float(model.uniform(1.0) @ (model.capacity @ model.uniform(1.0)))
        mean = float(model.uniform(1.0) @ (model.capacity @ behind)) / capacity
        values = shell.space.values(shell.space.points) @ field
        values = values - np.average(values, weights=shell.space.dx)
        weight = np.sqrt(shell.space.dx)
        rows = weight[:, None] * legvander2d(xi, zeta, [POLYNOMIAL_DEGREE, POLYNOMIAL_DEGREE])
        found = np.linalg.lstsq(rows, weight * values, rcond=None)[0]
        return cls(-mean, capacity, found.reshape(POLYNOMIAL_DEGREE + 1, POLYNOMIAL_DEGREE + 1))

    @property
    def conductance(self) -> float:
        """From the air to the plate, W/K, with which one lump lags as much."""
        return self.capacity / self.lag

    def uneven(self, xi: Numbers, zeta: Numbers) -> Numbers:
        """Return b less its mean (Q,), K per K/s, at normalised places (Q,)."""
        return np.asarray(
            legvander2d(xi, zeta, [POLYNOMIAL_DEGREE, POLYNOMIAL_DEGREE]) @ self.coefficients.ravel()
        )

    @property
    def effect(self) -> Effect:
        """The gradient, in proportion to the rate of the temperature."""

        def card(_experiment: Experiment) -> EffectCard:
            return EffectCard(
                name=NAME,
                summary="on a ramp the air warms one side of the plate sooner than the other",
                parameters=(Parameter("share", "1", 0.0, 1.0, 1.0),),
                needs="an up and a down ramp",
                separated_by="thermocouples at the plate's corners",
                title="uneven convection",
                phrase="a gradient of {share} of what the heat equation says",
            )

        def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
            moved = values["share"] * circumstances.point.rate * self.uneven(state.xi, state.zeta)
            return state.with_(temperature=state.temperature + moved)

        return Effect(card, apply)


def simulated_rig(experiment: AcquiredExperiment, file: Path, report: Progress) -> SimulatedParts:
    """Build the simulated rig around the twin.

    Parameters
    ----------
    file : Path
        The experiment's, for messages.
    report : callable
        Called with a stage's name and the share of it done.

    Raises
    ------
    CampaignFileError
        For what ``[simulation]`` lacks, or what the plate cannot have.
    """
    simulation = _simulation(experiment, file)
    laws = simulation.laws.laws()
    _require_covered(experiment, laws, file)
    silent_rig(experiment, file)  # wiring and modules are refused before a twin is built
    recorded = experiment.recorded(experiment.sample_rate)
    transfer: PlateTransfer
    behind = None if simulation.heat is None else PlateBehindAir.of(recorded, simulation.heat)
    uneven = behind is not None and simulation.heat is not None and any(simulation.heat.uneven)
    if simulation.effects or uneven:
        gradient = {NAME: behind.effect} if behind is not None and uneven else {}
        # without offsets it is the twin of `flexura gap`, which is kept
        twin = effect_twin(recorded, report, also=gradient, offset=OFFSET in simulation.effects)
        hidden = {**simulation.effects, **{name: {"share": 1.0} for name in gradient}}
        transfer = transfer_with_effects(twin, hidden, laws, file)
        _require_answerable(experiment, transfer, file)
    else:
        transfer = TwinTransfer(campaign_twin(recorded, report), laws)
    volts = np.array([response.volts for response in experiment.sensitivities.responses])
    plate = TwinPlate(transfer, _gain(experiment, simulation), sensitivity=volts)
    return parts_around(experiment, simulation, plate, file, behind)


def silent_rig(experiment: AcquiredExperiment, file: Path) -> SimulatedParts:
    """Build the simulated rig around a plate that does not respond; CampaignFileError for modules."""
    return parts_around(experiment, _simulation(experiment, file), _silent(experiment), file)


def parts_around(
    experiment: AcquiredExperiment,
    simulation: Simulation,
    plate: DrivenPlate,
    file: Path,
    behind: PlateBehindAir | None = None,
) -> SimulatedParts:
    """Build the simulated cards and oven of an experiment around a plate.

    Parameters
    ----------
    file : Path
        The experiment's, for messages.
    behind : PlateBehindAir, optional
        How heat passes into the plate; else as into that of `Chamber`.

    Raises
    ------
    CampaignFileError
        For modules, terminals or instruments that cannot be simulated.
    """
    wiring = experiment.cards
    if not isinstance(wiring, Wiring | SoundCard):
        problem = Problem(
            file.name, "cards.kind", repr(wiring.kind), "'ni' or 'soundcard': only these are simulated"
        )
        raise CampaignFileError(file.parent, [problem])
    force = experiment.sensitivities.drive.volts
    drive_scale = _gain(experiment, simulation) * force if experiment.drive else 1.0
    chamber = Chamber(room=experiment.oven.room_temperature)
    if behind is not None:
        heat = {"plate_capacity": behind.capacity, "plate_conductance": behind.conductance}
        chamber = dataclasses.replace(chamber, **heat)
    with simulating(file):
        return simulated_parts(
            wiring.model_copy(update={"grpc": None}) if isinstance(wiring, Wiring) else wiring,
            experiment.oven,
            plate,
            modules=simulated_modules(simulation, file),
            seed=simulation.seed,
            chamber=chamber,
            drive_scale=drive_scale,
            thermometer=experiment.thermometer,
            iepe_sensors=frozenset(wiring.iepe if isinstance(wiring, Wiring) else ()),
        )


@contextmanager
def simulating(file: Path) -> Iterator[None]:
    """Turn what cannot be simulated into a CampaignFileError that names the experiment's file."""
    try:
        yield
    except ValueError as error:
        allowed = "in [cards] terminals of simulation.modules, and instruments that can be simulated"
        problem = Problem(file.name, "cards, or an instrument", str(error), allowed)
        raise CampaignFileError(file.parent, [problem]) from error


def _gain(experiment: AcquiredExperiment, simulation: Simulation) -> float:
    """Return the true gain of the amplifier, V/V, or of the exciter, N/V."""
    return experiment.drive_gain if simulation.gain is None else simulation.gain


def _silent(experiment: AcquiredExperiment) -> DrivenPlate:
    """Return a plate that does not respond: cards read their inputs already when they are opened."""
    return lambda drive, rate, temperature: np.zeros((len(experiment.cards.responses), drive.size))


def _require_covered(experiment: AcquiredExperiment, laws: MaterialLaws, file: Path) -> None:
    """Raise CampaignFileError unless the laws reach over all sweeps and stay where the twin is certified."""
    programme, limits = experiment.programme, experiment.limits
    wanted = (programme.lowest - programme.tolerance - 1.0, programme.highest + programme.tolerance + 1.0)
    where = f"where sweeps are made (limits: {limits.coldest:g} to {limits.hottest:g} °C)"
    require_laws(experiment.plate, laws, wanted, file, where)


def require_laws(
    plate: Plate, laws: MaterialLaws, wanted: tuple[float, float], file: Path, where: str = "where it is measured"
) -> None:
    """Raise CampaignFileError unless laws reach over what is wanted and stay where the twin is certified.

    Parameters
    ----------
    wanted : (float, float)
        Degrees Celsius.
    file : Path
        The experiment's, for messages.
    where : str
        What is done between these temperatures, for messages.
    """
    low, high = laws.temperature_range
    problems = []
    if wanted[0] < low or wanted[1] > high:
        problems.append(
            Problem(
                file.name,
                "simulation.laws.temperature",
                f"{low:g} to {high:g} °C",
                f"to reach over {math.floor(wanted[0])} to {math.ceil(wanted[1])} °C, {where}",
            )
        )
    else:
        box = plate.ungrown(material_box(plate.material))
        values = laws.at(range(math.ceil(wanted[0]), math.floor(wanted[1]) + 1))
        for name in ("youngs_modulus", "poisson_ratio", "loss_factor"):
            least, most = float(getattr(values, name).min()), float(getattr(values, name).max())
            bottom, top = getattr(box, name)
            if least < bottom or most > top:
                seen = f"{least:.4g} to {most:.4g} between the values given"
                problems.append(
                    Problem(
                        file.name,
                        f"simulation.laws.{name}",
                        seen,
                        f"{bottom:g} to {top:g}, the twin's range",
                        "or declare what the plate is made of: [plate.material]",
                    )
                )
    if problems:
        raise CampaignFileError(file.parent, problems)


def transfer_with_effects(
    twin: Twin[EffectPlate], effects: Effects, laws: MaterialLaws, file: Path
) -> TwinTransfer:
    """Return what the plate answers with its effects; CampaignFileError for one that this plate cannot have."""
    unheld = [name for name in effects if name not in twin.cards]
    if unheld:
        allowed = "the effects " + ", ".join(twin.cards)
        seen = "an effect that this plate and its patches leave no room for"
        problems = [Problem(file.name, f"simulation.effects.{name}", seen, allowed) for name in unheld]
        raise CampaignFileError(file.parent, problems)
    if any(twin.library[name].needs_strain_energy for name in effects):
        low, high = laws.temperature_range
        if not low <= REFERENCE_TEMPERATURE <= high:
            allowed = f"to hold {REFERENCE_TEMPERATURE:g} °C, at which strain energies are counted"
            seen = f"{low:g} to {high:g} °C"
            raise CampaignFileError(
                file.parent, [Problem(file.name, "simulation.laws.temperature", seen, allowed)]
            )
        twin = twin.referred(laws.local(REFERENCE_TEMPERATURE))
    return TwinTransfer(twin, laws, with_shapes(twin.cards, effects))


def _require_answerable(experiment: AcquiredExperiment, transfer: TwinTransfer, file: Path) -> None:
    """Raise CampaignFileError where the effects lead beyond the laws or the twin, before the oven is started."""
    programme, level = experiment.programme, max(experiment.sweep.levels)
    margin = programme.tolerance + 1.0
    problems = []
    for leg in programme.legs:
        rate = programme.ramp_rate / 60.0 * (1.0 if leg == "up" else -1.0)
        for temperature in (programme.lowest - margin, programme.highest + margin):
            try:
                transfer(SweepPoint(temperature, rate, level), np.array(transfer.band))
            except ValueError as error:
                seen = f"at {temperature:g} °C on the way {leg}: {error}"
                allowed = "effects that keep the plate within simulation.laws and the twin's range"
                problems.append(Problem(file.name, "simulation.effects", seen, allowed))
    if problems:
        raise CampaignFileError(file.parent, problems)


def simulated_modules(simulation: Simulation, file: Path) -> dict[int, Module]:
    """Return what is plugged into the simulated chassis, by slot; CampaignFileError for what is not known."""
    known: dict[str, Module] = {module.name: module for module in (*KNOWN, *KNOWN_OUTPUTS, NI_9211, NI_9213)}
    found: dict[int, Module] = {}
    for slot, name in simulation.modules.items():
        module = known.get(name.upper().replace(" ", "-"))
        if module is None or slot not in tuple("12345678"):
            seen = f"slot {slot!r}: {name!r}"
            allowed = f"slots '1' to '8' with one of {', '.join(known)}"
            raise CampaignFileError(file.parent, [Problem(file.name, "simulation.modules", seen, allowed)])
        if isinstance(module, InputModule) and simulation.noise is not None:
            module = dataclasses.replace(module, noise=simulation.noise)
        found[int(slot)] = module
    return found
