"""Parts of a rig, real or simulated."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any

from drivers.clock import Clock
from drivers.ni.cards import Cards
from drivers.ovens.oven import Oven
from drivers.thermometers.thermometer import Thermometer


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
    """

    open_cards: Callable[[], Cards]
    open_oven: Callable[[], Oven]
    clock: Clock
    date: Callable[[], datetime]
    restore: Callable[[Oven, Sequence[Mapping[str, Any]]], None] = nothing_to_restore
    open_thermometer: Callable[[], Thermometer] | None = None
