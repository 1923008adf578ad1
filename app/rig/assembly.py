"""The rig of an experiment: real cards and oven, or simulated ones."""

import dataclasses
import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from analysis.progress import Progress
from analysis.protocol.limits import Limits
from app.files.declarations.experiment import AcquiredExperiment, RigKind
from app.files.declarations.hammer_experiment import HammerExperiment
from app.files.declarations.instrument_sections import OvenSection
from drivers.clock import SystemClock
from drivers.ni.cards import Cards
from drivers.rig.occupancy import instrument_places
from drivers.rig.rig import Aftercare, Rig
from drivers.thermometers.settings import ThermometerSettings
from drivers.watchdog.frames import WatchdogSettings
from drivers.watchdog.remote_oven import RemoteOven
from drivers.watchdog.rest_watch import RestRule

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
        from drivers.ni.simulated.loopback import serving

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
