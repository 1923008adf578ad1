"""What a rig is made of."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any

from drivers.clock import Clock
from drivers.ni.cards import Cards
from drivers.ovens.oven import Oven
from drivers.thermometers.thermometer import Thermometer


def nothing_to_restore(oven: Oven, events: Sequence[Mapping[str, Any]]) -> None:
    """Leave the rig as it is: a real one has not waited."""


@dataclass(frozen=True)
class Rig:
    """Ways to open the cards, the oven and the thermometer, and the time they live in.

    Attributes
    ----------
    open_cards : callable
        May be called again after the cards were lost.
    open_oven : callable
    clock : Clock
    date : callable
        Date and time of day now, with its zone.
    restore : callable
        Told the open oven and the log of an interrupted campaign, before it is taken up again. A
        simulated rig, whose time stands still while nobody runs it, goes back to where it was.
    open_thermometer : callable, optional
        Of the plate; without it, its temperature is that of the cards' thermocouples.
    """

    open_cards: Callable[[], Cards]
    open_oven: Callable[[], Oven]
    clock: Clock
    date: Callable[[], datetime]
    restore: Callable[[Oven, Sequence[Mapping[str, Any]]], None] = nothing_to_restore
    open_thermometer: Callable[[], Thermometer] | None = None
