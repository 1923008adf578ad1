"""The rig of a hammer test: real cards, or simulated ones around the twin and a hammer, with an oven or none."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from analysis.arrays import Real
from analysis.progress import Progress
from app.files.declarations.experiment import RigKind
from app.files.declarations.hammer_experiment import HammerExperiment, HammerSimulation, require_simulated
from drivers.clock import SystemClock, VirtualClock
from drivers.hammer.hammer_rig import HammerInputs, HammerRig, nobody

if TYPE_CHECKING:
    from app.rig.simulated_plate import PlateTransfer
    from drivers.hammer.simulated import PlateUnderHammer, SimulatedHammer
    from drivers.ni.simulated.servicer import SimulatedDaq
    from drivers.ni.simulated.surroundings import Module
    from drivers.rig.rig import Rig
    from drivers.rig.simulated import SimulatedParts


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
        from drivers.ni.endless_inputs import EndlessInputs
        from drivers.ni.simulated.in_process import InProcessChannel

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
    from drivers.ni.simulated.loopback import serving

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
    from drivers.ovens.simulated.regulated_oven import RegulatedOven
    from drivers.ovens.simulated.thermal import Chamber
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
    from drivers.ni.endless_inputs import EndlessInputs, as_cards

    def opened() -> EndlessInputs:
        return EndlessInputs(experiment.cards)

    oven: Rig | None = None
    if experiment.oven is not None:
        from app.rig.assembly import real_rig

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
