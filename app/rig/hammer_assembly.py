"""The rig of a hammer test: real cards, or simulated ones around the twin and a hammer."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from analysis.arrays import Real
from analysis.progress import Progress
from app.files.campaign_error import CampaignFileError, Problem
from app.files.experiment_toml import RigKind
from app.files.hammer_experiment import HammerExperiment, HammerSimulation, require_simulated
from drivers.clock import SystemClock, VirtualClock
from drivers.hammer.hammer_rig import HammerInputs, HammerRig
from drivers.rig.occupancy import instrument_places

if TYPE_CHECKING:
    from app.rig.plate_transfer import PlateTransfer
    from drivers.hammer.simulated import PlateUnderHammer, SimulatedHammer
    from drivers.ni.simulated.servicer import SimulatedDaq

MEMORY = 6.0
"""s for which the coupling of the inputs is followed: of a corner of 0.5 Hz 1e-8 is left."""


@dataclass(frozen=True)
class SimulatedHammerRig:
    """Parts of a simulated rig, for tests that inspect it.

    Attributes
    ----------
    experiment : HammerExperiment
    clock : VirtualClock
    hammer : SimulatedHammer
    server : SimulatedDaq
    address : str or None
        ``host:port`` of the server; None to call it inside this process.
    """

    experiment: HammerExperiment
    clock: VirtualClock
    hammer: "SimulatedHammer"
    server: "SimulatedDaq"
    address: str | None = None

    def rig(self) -> HammerRig:
        """Return the rig as a campaign uses it."""
        return HammerRig(self._open, self.clock, self._date, self.hammer.ask)

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
        Time on the rig's clock at which the campaign was interrupted, s: where a simulated one goes on.
    report : callable
        Called with the stage's name and the share done, if the twin has to be reduced first.

    Raises
    ------
    CampaignFileError
        If the simulated rig is asked for and the file does not say enough about it.
    """
    if kind != "simulated":
        yield HammerRig(lambda: _real_inputs(experiment), SystemClock(), lambda: datetime.now(UTC))
        return
    simulation = require_simulated(experiment, file)
    from app.rig.struck_plate import TwinUnderHammer

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
    """Build simulated cards, and whoever holds the hammer, around a plate.

    Parameters
    ----------
    file : Path
        The experiment's, for messages.
    since : float
        As in `hammer_rig`.

    Raises
    ------
    CampaignFileError
        For modules and terminals that cannot be simulated.
    """
    from app.rig.simulated_rig import simulated_modules
    from drivers.hammer.simulated import HandSettings, SimulatedHammer
    from drivers.ni.output_modules import NI_9260, OutputModule
    from drivers.ni.simulated.servicer import SimulatedDaq
    from drivers.ni.simulated.surroundings import Surroundings

    cards, clock = experiment.cards, VirtualClock(since)
    modules = simulated_modules(simulation, file)
    outputs = [slot for slot, module in modules.items() if isinstance(module, OutputModule)]
    if not outputs:  # the simulated chassis is made around one; nothing is wired to it here
        outputs = [next(slot for slot in range(1, 9) if slot not in modules)]
        modules[outputs[0]] = NI_9260
    chassis, _, rest = cards.drive_input.partition("Mod")
    found = modules.get(int(rest[0])) if rest[:1].isdecimal() else None
    hand = simulation.hammer
    hammer = SimulatedHammer(
        plate,
        HandSettings(
            hand.peak,
            hand.spread,
            hand.width,
            hand.double_hits,
            hand.overloads,
            hand.pause,
            experiment.hammer.duration,
        ),
        clock,
        simulation.temperature,
        experiment.mallet.sensitivity,
        min(cards.input_range, float(getattr(found, "full_scale", cards.input_range))),
        simulation.seed,
    )
    try:
        surroundings = Surroundings(
            plate=_unplayed,
            sensors={terminal: row for row, terminal in enumerate(cards.responses)},
            drive_inputs=frozenset({cards.drive_input}),
            output=f"{chassis}Mod{outputs[0]}/ao0",
            plate_temperature=lambda moments: np.full(np.shape(moments), hammer.temperature),
            chassis=chassis,
            modules=modules,
            iepe_sensors=frozenset(cards.iepe),
            memory=MEMORY,
            hammer=hammer,
        )
    except ValueError as error:
        problem = Problem(file.name, "simulation", str(error), "terminals of simulation.modules")
        raise CampaignFileError(file.parent, [problem]) from error
    return SimulatedHammerRig(experiment, clock, hammer, SimulatedDaq(surroundings, clock, simulation.seed))


def hammer_places(experiment: HammerExperiment, kind: RigKind) -> tuple[str, ...]:
    """Return what of the rig only one process can use; of a simulated one nothing."""
    return () if kind == "simulated" else instrument_places(None, None, experiment.cards)


def _real_inputs(experiment: HammerExperiment) -> HammerInputs:
    from drivers.ni.endless_inputs import EndlessInputs

    return EndlessInputs(experiment.cards)


def _transfer(
    experiment: HammerExperiment, simulation: HammerSimulation, file: Path, report: Progress
) -> "PlateTransfer":
    """Return the twin of the plate with a force at every point, with the effects it is simulated to have."""
    from app.rig.plate_transfer import TwinTransfer
    from app.rig.simulated_rig import require_laws, transfer_with_effects
    from app.twins.campaign_twin import campaign_twin, effect_twin

    struck, laws = experiment.struck(), simulation.laws.laws()
    require_laws(experiment.plate, laws, (simulation.temperature - 1.0, simulation.temperature + 1.0), file)
    if not simulation.effects:
        return TwinTransfer(campaign_twin(struck, report), laws)
    return transfer_with_effects(effect_twin(struck, report), simulation.effects, laws, file)


def _unplayed(drive: Real, sample_rate: float, temperature: Real) -> Real:
    raise AssertionError("nothing is played in a hammer test")
