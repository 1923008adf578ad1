"""The rig of an experiment: real cards and oven, or simulated ones.

The rig of a hammer test: real cards, or simulated ones around the twin and a hammer, with an oven or none.
"""

import dataclasses
import logging
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from analysis.arrays import Real
from analysis.progress import Progress
from analysis.protocol.limits import Limits
from app.files.declarations.experiment import AcquiredExperiment, OvenSection, RigKind
from app.files.declarations.hammer_experiment import HammerExperiment, HammerSimulation, require_simulated
from drivers.clock import SystemClock, VirtualClock
from drivers.hammer.hammer_rig import HammerInputs, HammerRig, nobody
from drivers.ni.cards import Cards
from drivers.rig.occupancy import instrument_places
from drivers.rig.rig import Aftercare, Rig
from drivers.thermometers.thermometer import ThermometerSettings
from drivers.watchdog.frames import WatchdogSettings
from drivers.watchdog.guard import RestRule
from drivers.watchdog.remote_oven import RemoteOven

if TYPE_CHECKING:
    from app.rig.simulated_plate import PlateTransfer
    from drivers.hammer.simulated import PlateUnderHammer, SimulatedHammer
    from drivers.ni.simulated.servicer import SimulatedDaq
    from drivers.ni.simulated.surroundings import Module
    from drivers.rig.rig import Rig
    from drivers.rig.simulated import SimulatedParts

log = logging.getLogger(__name__)


@contextmanager
def rig_of(experiment: AcquiredExperiment, kind: RigKind, file: Path, report: Progress) -> Iterator[Rig]:
    """Yield the rig that runs an experiment.

    Parameters
    ----------
    kind : str
        ``simulated``, ``real`` or, an older word for that, ``ni``.
    file : Path
        The experiment's, for messages.
    report : callable
        Called with the stage's name and the share done, if the twin has to be reduced first.

    Raises
    ------
    CampaignFileError
        If the simulated rig is asked for and the file does not say enough about it.
    """
    if kind != "simulated":
        yield _real_rig(experiment)
        return
    from app.rig.simulated_rig import simulated_rig

    parts = simulated_rig(experiment, file, report)
    served = experiment.simulation is not None and experiment.simulation.served
    if served and parts.server is not None:
        from drivers.ni.simulated.servicer import serving

        with serving(parts.server) as address:
            yield dataclasses.replace(parts, address=address).rig()
    else:
        yield parts.rig()


def rig_places(experiment: AcquiredExperiment | HammerExperiment, kind: RigKind) -> tuple[str, ...]:
    """Return what of a rig only one process can use, in the same words for everybody; of a simulated one none."""
    if kind == "simulated":
        return ()
    return instrument_places(experiment.oven, experiment.thermometer, experiment.cards)


def still_rig(experiment: AcquiredExperiment, kind: RigKind, file: Path) -> Rig:
    """Return the rig for a caller that plays nothing on it: a simulated one then needs no twin.

    Parameters
    ----------
    kind : str
        As in `rig_of`.
    file : Path
        The experiment's, for messages.

    Raises
    ------
    CampaignFileError
        If the simulated rig is asked for and the file does not say enough about it.
    """
    if kind != "simulated":
        return _real_rig(experiment)
    from app.rig.simulated_rig import silent_rig

    return silent_rig(experiment, file).rig()


def _real_rig(experiment: AcquiredExperiment) -> Rig:
    drive = experiment.cards.model_dump(mode="json")
    return real_rig(experiment.cards.open, experiment.oven, experiment.thermometer, drive)


def real_rig(
    open_cards: Callable[[], Cards],
    oven: OvenSection,
    thermometer: ThermometerSettings | None,
    drive: dict[str, Any] | None,
) -> Rig:
    """Return a real rig.

    Parameters
    ----------
    open_cards : callable
    oven : OvenSection
        Of the experiment.
    thermometer : ThermometerSettings, optional
    drive : dict, optional
        The ``[cards]`` whose output the watchdog brings to 0 V; None where nothing is driven.
    """
    clock = SystemClock()
    return Rig(
        open_cards=open_cards,
        open_oven=lambda: oven.open(clock),
        clock=clock,
        date=lambda: datetime.now(UTC),
        open_thermometer=None if thermometer is None else lambda: thermometer.open(clock),
        rest_rule=_rest_rule(oven),
        tell=lambda message: log.warning("%s", message),
        supervise=lambda limits, asked, aftercare: _watchdog(oven, drive, clock, limits, asked, aftercare),
    )


def _rest_rule(oven: OvenSection) -> RestRule:
    return RestRule(oven.rest_temperature(oven.room_temperature))


def _watchdog(
    oven: OvenSection,
    drive: dict[str, Any] | None,
    clock: SystemClock,
    limits: Limits,
    asked_to_end: Callable[[], None],
    aftercare: Aftercare,
) -> RemoteOven:
    """Open the oven in the watchdog's process."""
    settings = WatchdogSettings(
        oven=oven.model_dump(mode="json", exclude={"room_temperature"}),
        limits=limits,
        cards=drive,
        rest=_rest_rule(oven),
        log=None if aftercare.log is None else str(aftercare.log),
    )
    return RemoteOven(settings, lambda: oven.open(clock), asked_to_end, aftercare.locks)


@dataclass(frozen=True)
class SimulatedHammerRig:
    """Parts of a simulated rig, for tests that inspect it.

    Attributes
    ----------
    experiment : HammerExperiment
    clock : VirtualClock
    hammer : SimulatedHammer
    server : SimulatedDaq
    oven : SimulatedParts or None
        With the oven in which the plate is; None for a plate in the room.
    address : str or None
        ``host:port`` of the server; None to call it inside this process.
    """

    experiment: HammerExperiment
    clock: VirtualClock
    hammer: "SimulatedHammer"
    server: "SimulatedDaq"
    oven: "SimulatedParts | None" = None
    address: str | None = None

    def rig(self) -> HammerRig:
        """Return the rig as a campaign uses it."""
        oven = None if self.oven is None else replace(self.oven, address=self.address).rig()
        return HammerRig(self._open, self.clock, self._date, self.hammer.ask, oven)

    def _open(self) -> HammerInputs:
        from drivers.ni.daqmx import EndlessInputs
        from drivers.ni.simulated.servicer import InProcessChannel

        cards = self.experiment.cards.model_copy(update={"grpc": self.address})
        return EndlessInputs(cards, None if self.address else InProcessChannel(self.server))

    def _date(self) -> datetime:
        from drivers.rig.simulated import EPOCH

        return EPOCH + timedelta(seconds=round(self.clock.now(), 3))


@contextmanager
def hammer_rig(
    experiment: HammerExperiment, kind: RigKind, file: Path, since: float, report: Progress
) -> Iterator[HammerRig]:
    """Yield the rig of a hammer test.

    Parameters
    ----------
    kind : str
        ``simulated``, ``real`` or, an older word for that, ``ni``.
    file : Path
        The experiment's, for messages.
    since : float
        Time on the rig's clock at which the campaign was interrupted, s: where a simulated one without an oven
        goes on.
    report : callable
        Called with the stage's name and the share done, if the twin has to be reduced first.

    Raises
    ------
    CampaignFileError
        If the simulated rig is asked for and the file does not say enough about it.
    """
    if kind != "simulated":
        yield _real(experiment)
        return
    simulation = require_simulated(experiment, file)
    from app.rig.simulated_plate import TwinUnderHammer

    plate = TwinUnderHammer(_transfer(experiment, simulation, file, report), np.array(experiment.volts[1:]))
    parts = simulated_hammer_rig(experiment, simulation, plate, file, since)
    if not simulation.served:
        yield parts.rig()
        return
    from drivers.ni.simulated.servicer import serving

    with serving(parts.server) as address:
        yield replace(parts, address=address).rig()


def simulated_hammer_rig(
    experiment: HammerExperiment,
    simulation: HammerSimulation,
    plate: "PlateUnderHammer",
    file: Path,
    since: float = 0.0,
) -> SimulatedHammerRig:
    """Build simulated cards, an oven if there is one, and whoever holds the hammer, around a plate.

    Parameters
    ----------
    file : Path
        The experiment's, for messages.
    since : float
        As in `hammer_rig`.

    Raises
    ------
    CampaignFileError
        For modules, terminals and instruments that cannot be simulated.
    """
    from app.rig.simulated_rig import simulated_modules, simulating
    from drivers.hammer.simulated import HandSettings, SimulatedHammer, struck_surroundings
    from drivers.ni.simulated.servicer import SimulatedDaq

    cards, modules, hand = experiment.cards, simulated_modules(simulation, file), simulation.hammer
    slot = cards.drive_input.split("/")[0].partition("Mod")[2]
    module = modules.get(int(slot)) if slot.isdecimal() else None
    clock = VirtualClock(since if experiment.oven is None else 0.0)
    hammer = SimulatedHammer(
        plate,
        HandSettings(
            hand.peak,
            hand.spread,
            hand.width,
            hand.double_hits,
            hand.overloads,
            hand.pause,
            ring=experiment.hammer.duration,
        ),
        clock,
        lambda: simulation.temperature,
        experiment.mallet.sensitivity,
        min(cards.input_range, float(getattr(module, "full_scale", cards.input_range))),
        simulation.seed,
    )
    with simulating(file):
        if experiment.oven is not None:
            return _in_oven(experiment, simulation, hammer, clock, modules)
        surroundings = struck_surroundings(
            cards, hammer, modules, lambda moments: np.full(np.shape(moments), simulation.temperature)
        )
    return SimulatedHammerRig(experiment, clock, hammer, SimulatedDaq(surroundings, clock, simulation.seed))


def _in_oven(
    experiment: HammerExperiment,
    simulation: HammerSimulation,
    hammer: "SimulatedHammer",
    clock: VirtualClock,
    modules: "Mapping[int, Module]",
) -> SimulatedHammerRig:
    """Put the plate into a simulated oven; ValueError for instruments that cannot be simulated."""
    from drivers.hammer.simulated import struck_surroundings
    from drivers.ni.simulated.servicer import SimulatedDaq
    from drivers.ovens.simulated.regulated_oven import Chamber, RegulatedOven
    from drivers.rig.simulated import PlateForecast, parts_in_oven

    if experiment.oven is None:
        raise AssertionError("asked for with an oven only")
    chamber = Chamber(room=experiment.oven.room_temperature)
    body = RegulatedOven(clock, np.random.default_rng(simulation.seed), chamber)
    hammer.temperature = lambda: body.plate
    forecast = PlateForecast(clock, body, chamber)
    server = SimulatedDaq(struck_surroundings(experiment.cards, hammer, modules, forecast), clock, simulation.seed)
    parts = parts_in_oven(
        clock, body, server, experiment.cards, experiment.oven, experiment.thermometer, room=chamber.room
    )
    return SimulatedHammerRig(experiment, clock, hammer, server, parts)


def still_oven(experiment: HammerExperiment, kind: RigKind, file: Path) -> "Rig | None":
    """Return the rig of the oven for a caller that only brings it to rest; None for a test without an oven.

    Parameters
    ----------
    kind : str
        As in `hammer_rig`.
    file : Path
        The experiment's, for messages.

    Raises
    ------
    CampaignFileError
        If the simulated rig is asked for and the file does not say enough about it.
    """
    if kind != "simulated":
        return _real(experiment).oven
    silent = np.zeros((len(experiment.cards.responses), 1))

    def plate(point: int, force: Real, sample_rate: float, temperature: float) -> Real:
        return np.broadcast_to(silent, (len(silent), force.size))

    return simulated_hammer_rig(experiment, require_simulated(experiment, file), plate, file).rig().oven


def _real(experiment: HammerExperiment) -> HammerRig:
    from drivers.ni.daqmx import EndlessInputs, as_cards

    def opened() -> EndlessInputs:
        return EndlessInputs(experiment.cards)

    oven: Rig | None = None
    if experiment.oven is not None:
        oven = real_rig(lambda: as_cards(opened()), experiment.oven, experiment.thermometer, None)
    return HammerRig(opened, SystemClock(), lambda: datetime.now(UTC), nobody, oven)


def _transfer(
    experiment: HammerExperiment, simulation: HammerSimulation, file: Path, report: Progress
) -> "PlateTransfer":
    """Return the twin of the plate with a force at every point, with the effects it is simulated to have."""
    from app.rig.simulated_plate import TwinTransfer
    from app.rig.simulated_rig import require_laws, transfer_with_effects
    from app.twins.campaign_twin import campaign_twin, effect_twin

    struck, laws = experiment.struck(), simulation.laws.laws()
    wanted = [simulation.temperature if one is None else one for one in experiment.temperatures]
    margin = 1.0 if experiment.set_points is None else experiment.set_points.within + 1.0
    require_laws(experiment.plate, laws, (min(wanted) - margin, max(wanted) + margin), file)
    if not simulation.effects:
        return TwinTransfer(campaign_twin(struck, report), laws)
    return transfer_with_effects(effect_twin(struck, report), simulation.effects, laws, file)
