"""Parts of a rig, real or simulated."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

from analysis.protocol.limits import Limits
from drivers.clock import Clock
from drivers.ni.cards import Cards
from drivers.ovens.oven import Oven
from drivers.thermometers.thermometer import Thermometer
from drivers.watchdog.guard import RestRule
from drivers.watchdog.remote_oven import RemoteOven
from drivers.watchdog.supervision import SupervisedOven, untold


@dataclass(frozen=True)
class Aftercare:
    """What a watchdog needs that looks after the oven when the campaign's process is no more.

    Attributes
    ----------
    locks : tuple of int
        Descriptors of the rig's locks: as long as it holds them open, nobody else takes the rig.
    log : Path or None
        File in which it says what there may be nobody to hear.
    """

    locks: tuple[int, ...] = ()
    log: Path | None = None


AskedToEnd = Callable[[], None]
"""Raises if the session is to end."""


def nothing_to_restore(oven: Oven, events: Sequence[Mapping[str, Any]]) -> None:
    """Do nothing: a real rig's state needs no restoring."""


@dataclass(frozen=True)
class Rig:
    """Functions that open the cards, the oven and the thermometer, and their clock.

    Attributes
    ----------
    open_cards : callable
        May be called again after the cards were lost.
    open_oven : callable
    clock : Clock
    date : callable
        Date and time of day now, with its zone.
    restore : callable
        Called with the open oven and the log of an interrupted campaign before it is resumed. A simulated rig,
        whose time stops with the process, is set to its last state.
    open_thermometer : callable, optional
        Opens the plate's thermometer; without it, the cards' thermocouples measure the plate's temperature.
    rest_rule : RestRule, optional
        When the oven, switched off, counts as at rest; without it, as soon as it reads back as off.
    tell : callable
        Receives what people may wonder about while the rig comes to rest.
    supervise : callable, optional
        Opens the oven in a process of its own that supervises it; without it, the supervision runs on `clock`
        inside this process.
    """

    open_cards: Callable[[], Cards]
    open_oven: Callable[[], Oven]
    clock: Clock
    date: Callable[[], datetime]
    restore: Callable[[Oven, Sequence[Mapping[str, Any]]], None] = nothing_to_restore
    open_thermometer: Callable[[], Thermometer] | None = None
    rest_rule: RestRule | None = None
    tell: Callable[[str], None] = untold
    supervise: Callable[[Limits, AskedToEnd, Aftercare], RemoteOven] | None = None

    def open_supervised(
        self, limits: Limits, asked_to_end: AskedToEnd, aftercare: Aftercare
    ) -> SupervisedOven | RemoteOven:
        """Open the oven for a session, supervised from now on.

        Parameters
        ----------
        asked_to_end : callable
            Raises if the session is to end.
        aftercare : Aftercare
            For a watchdog that outlives this process.

        Raises
        ------
        OvenError
            If it cannot be reached.
        """
        if self.supervise is not None:
            return self.supervise(limits, asked_to_end, aftercare)
        oven = SupervisedOven(self.open_oven(), limits, self.clock, asked_to_end, self.rest_rule)
        oven.begin()
        return oven
