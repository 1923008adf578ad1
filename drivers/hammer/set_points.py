"""A hammer test at several temperatures: the oven is brought to each and holds it while the plate is hit."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, cast

from analysis.protocol.protocol import AcquisitionProtocol
from drivers.hammer.campaign import HammerCampaign
from drivers.hammer.hammer_rig import HammerInputs
from drivers.hammer.judged_hit import HitTemperature
from drivers.hammer.store import HammerStore
from drivers.ni.errors import DaqError
from drivers.ovens.error import OvenError
from drivers.rig.approach import LONGEST_PAUSE, Approach
from drivers.rig.errors import RESUME, RigStopped
from drivers.rig.readings import Reading
from drivers.rig.session import Session
from drivers.rig.station import Station
from drivers.rig.store import Store

MOST_RESETTLINGS = 20
"""Times that a set-point is settled again because the plate left it: an oven that cannot hold it is told."""


@dataclass
class HeldPlate:
    """The plate in an oven that holds a set-point.

    Attributes
    ----------
    session : Session
        Open.
    protocol : AcquisitionProtocol
        Its programme says how the oven moves, and when a temperature is reached.
    store : HammerStore
        For the log.
    told : callable
        Called with the activity and a reading.
    """

    session: Session
    protocol: AcquisitionProtocol
    store: HammerStore
    told: Callable[[str, Reading], None]

    def __post_init__(self) -> None:
        # of a store the station writes the log only
        self._station = Station(self.session, self.protocol, cast(Store, self.store))
        self._approach = Approach(self._station, self.protocol)
        self._next = -math.inf

    def restore(self, events: Sequence[Mapping[str, Any]], temperatures: Sequence[float]) -> None:
        """Set a simulated rig to its last state; on a new one, check what can be before anything moves."""
        if events:
            self._station.restore(events)
        else:
            self._station.require_celsius()
            self._station.require_reachable(temperatures)
        self._station.note("resumed" if events else "begun")

    def temperature(self) -> HitTemperature:
        """Return the temperature that counts, and what is in doubt about it."""
        reading = self._station.reading()
        if reading is None:
            return HitTemperature(math.nan)
        return HitTemperature(self._station.watched(reading), "; ".join(reading.doubts))

    def mark(self, number: int) -> None:
        """Note that a hit was kept at the last reading, to be judged again by what is learnt later."""
        self._station.mark(number)

    def tell_mislabelled(self) -> None:
        """Log the hits whose temperature is in doubt by what was learnt since; see `Station.tell_mislabelled`."""
        self._station.tell_mislabelled()

    def check(self) -> None:
        """Raise if the session is to end, or a reading says so: one is made at every interval."""
        self.session.check()
        now = self._station.now
        if now >= self._next:
            self._next = now + self.protocol.programme.poll_interval
            reading = self._station.reading()
            if reading is not None:
                self.told("held", reading)

    def settle(self, target: float) -> None:
        """Bring the plate to a temperature, and wait until it has stayed there, see `Approach.settle`."""
        programme = self.protocol.programme

        def watch(stage: str, reading: Reading, _: bool) -> bool:
            self.told(stage, reading)
            return False

        stage = f"way to {target:g} °C"
        self._approach.settle(watch, target, programme.ramp_rate, programme.soak_before, stage)


def run_set_points(
    temperatures: Sequence[float], held: HeldPlate, campaign: HammerCampaign, events: Sequence[Mapping[str, Any]]
) -> bool:
    """Measure the hits that are missing, set-point after set-point; the session brings the oven to rest.

    Parameters
    ----------
    temperatures : sequence of float
        Degrees Celsius.
    campaign : HammerCampaign
        Its temperature and its checks are replaced by those of the held plate.
    events : sequence of mapping
        The log, as it was before this run.

    Returns
    -------
    bool
        False where it was stopped by a key.

    Raises
    ------
    RigStopped
        If a set-point is not reached or not held, or the rig cannot continue now. The same call resumes.
    """
    within = held.protocol.programme.settling.within
    try:
        held.restore(events, temperatures)
        for number, target in enumerate(temperatures):
            drifted = 0
            while campaign.progress.next_point(number) is not None:
                held.settle(target)
                here = replace(
                    campaign,
                    inputs=cast(HammerInputs, held.session.cards),  # perhaps lost and opened again on the way
                    temperature=held.temperature,
                    check=held.check,
                    held=(target - within, target + within),
                    mark=held.mark,
                    patience=LONGEST_PAUSE,
                )
                ended = here.run(number)
                if ended == "stopped":
                    return False
                drifted += ended == "drifted"
                if drifted > MOST_RESETTLINGS:
                    raise RigStopped(
                        f"the plate left {target:g} °C by more than {within:g} K {drifted} times",
                        "Can the oven hold it? Look at the oven, or enlarge set_points.within",
                    )
    except (DaqError, OvenError) as error:
        raise RigStopped(str(error), RESUME) from error
    finally:
        held.tell_mislabelled()
    return True
