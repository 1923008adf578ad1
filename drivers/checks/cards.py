"""Declared cards put on trial: NI's against the simulated chassis, or, where that is asked for, the real ones."""

import re
from collections.abc import Callable, Iterator

import numpy as np

from drivers.checks.cards_checks import CardsOnTrial, cards_checks
from drivers.checks.instruments import NoCounterpart
from drivers.checks.trial import CheckVerdict, NotChecked, verdicts
from drivers.clock import VirtualClock
from drivers.ni.cards import Cards, CardsSettings
from drivers.ni.daqmx import DaqmxCards
from drivers.ni.modules import NI_9234
from drivers.ni.output_modules import NI_9260
from drivers.ni.simulated.faults import Faults
from drivers.ni.simulated.in_process import InProcessChannel
from drivers.ni.simulated.servicer import SimulatedDaq
from drivers.ni.simulated.surroundings import Module, Surroundings
from drivers.ni.thermocouple_modules import NI_9211
from drivers.ni.wiring import Wiring

PLAYED_RANGE_SHARE = 0.01
"""Of output_range that real cards play; a simulated one plays half of it."""
SLOT = re.compile(r"(.+)Mod([1-8])/.*")


def check_cards(settings: CardsSettings) -> Iterator[CheckVerdict]:
    """Put the driver on trial against the simulated chassis; touches no hardware.

    Raises
    ------
    NoCounterpart
        For cards that are no modules of one CompactDAQ chassis.
    """
    if not isinstance(settings, Wiring):
        raise NoCounterpart
    clock = VirtualClock()
    server = SimulatedDaq(_chassis(settings), clock)

    def lose(away: bool) -> None:
        now = clock.now()
        server.inject(Faults(unplugged=(now, now + 1e9)) if away else Faults())

    wiring = settings.model_copy(update={"grpc": None})
    return _verdicts(
        settings, lambda: DaqmxCards(wiring, InProcessChannel(server)), server.output_voltage, 0.5, lose
    )


def check_real_cards(settings: CardsSettings) -> Iterator[CheckVerdict]:
    """Put the driver on trial at the cards themselves, which play a hundredth of output_range."""

    def output() -> float:
        raise NotChecked("only its driver can read the output of a real card; measure it")

    def lose(away: bool) -> None:
        raise NotChecked("real cards cannot be unplugged by a program")

    return _verdicts(settings, settings.open, output, PLAYED_RANGE_SHARE, lose)


def _verdicts(
    settings: CardsSettings,
    opened: Callable[[], Cards],
    output: Callable[[], float],
    share: float,
    lose: Callable[[bool], None],
) -> Iterator[CheckVerdict]:
    trial = CardsOnTrial(
        open=opened,
        output=output,
        peak=share * settings.output_range,
        output_range=settings.output_range,
        responses=len(settings.responses),
        thermocouples=settings.has_thermocouples,
        lose=lose,
    )
    return verdicts(cards_checks(trial))


def _chassis(wiring: Wiring) -> Surroundings:
    """Return a chassis that has what the wiring names, around a plate that gives the drive back."""
    modules: dict[int, Module] = {}
    names = set()
    for terminals, module in (
        ((wiring.output,), NI_9260),
        (wiring.inputs, NI_9234),
        (wiring.thermocouples, NI_9211),
    ):
        for terminal in terminals:
            place = SLOT.fullmatch(terminal)
            if place is None:
                raise NoCounterpart
            names.add(place[1])
            modules[int(place[2])] = module
    if len(names) != 1:
        raise NoCounterpart
    rows = {terminal: row for row, terminal in enumerate(wiring.responses)}
    try:
        return Surroundings(
            plate=lambda drive, rate, temperature: np.tile(drive, (len(rows), 1)),
            sensors=rows,
            drive_inputs=frozenset({wiring.drive_input}),
            output=wiring.output,
            chassis=names.pop(),
            modules=modules,
        )
    except ValueError as error:  # a terminal that none of these modules has
        raise NoCounterpart from error
