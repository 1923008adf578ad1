"""Declared cards put on trial: NI's against the simulated chassis, or, where that is asked for, the real ones.

The checks are what every driver of cards has to bear.
"""

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from drivers.checks.instruments import NoCounterpart
from drivers.checks.trial import Check, CheckVerdict, Failed, NotChecked, verdicts
from drivers.clock import VirtualClock
from drivers.ni.cards import Cards, CardsSettings, DaqError
from drivers.ni.daqmx import DaqmxCards
from drivers.ni.modules import NI_9211, NI_9234, NI_9260
from drivers.ni.simulated.faults import Faults
from drivers.ni.simulated.servicer import InProcessChannel, SimulatedDaq
from drivers.ni.simulated.surroundings import Module, Surroundings
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


DRIVE_SECONDS = 0.1
"""Of a drive."""


@dataclass(frozen=True)
class CardsOnTrial:
    """Cards that checks may play on.

    Attributes
    ----------
    open : callable
        Opens them anew.
    output : callable
        Voltage at the output now, V; raises NotChecked where nothing but the driver could say.
    peak : float
        Of what is played, V.
    output_range : float
        Declared, V.
    responses : int
        How many are declared.
    thermocouples : bool
        Whether any is declared.
    lose : callable
        Takes the hardware away (True) or gives it back; raises NotChecked where that cannot be.
    """

    open: Callable[[], Cards]
    output: Callable[[], float]
    peak: float
    output_range: float
    responses: int
    thermocouples: bool
    lose: Callable[[bool], None]


def cards_checks(trial: CardsOnTrial) -> list[Check]:
    """Return all checks; each ends with the cards closed."""
    return [Check(name, why, partial(_opened, trial, what)) for name, why, what in CHECKS]


def _opened(trial: CardsOnTrial, what: Callable[[CardsOnTrial, Cards], None]) -> None:
    cards = trial.open()
    try:
        what(trial, cards)
    finally:
        cards.close()


def _at_rest(trial: CardsOnTrial, after: str) -> None:
    if (volts := trial.output()) != 0.0:
        raise Failed(f"after {after} the output is at {volts:g} V")


def _opens(trial: CardsOnTrial, cards: Cards) -> None:
    _at_rest(trial, "opening")


def _drive(trial: CardsOnTrial, cards: Cards) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    moments = np.arange(round(DRIVE_SECONDS * cards.sample_rate)) / cards.sample_rate
    return np.asarray(trial.peak * np.sin(2.0 * np.pi * 200.0 * moments), dtype=np.float64)


def _plays(trial: CardsOnTrial, cards: Cards) -> None:
    drive = _drive(trial, cards)
    record = cards.sweep(drive)
    shapes = (record.drive.shape, record.responses.shape)
    if shapes != (drive.shape, (trial.responses, drive.size)):
        raise Failed(f"a drive of {drive.size} samples came back as {shapes[0]}, responses as {shapes[1]}")
    if not (np.isfinite(record.drive).all() and np.isfinite(record.responses).all()):
        raise Failed("what came back is not finite")
    if abs(record.sample_rate / cards.sample_rate - 1.0) > 1e-3:
        raise Failed(f"the record's rate is {record.sample_rate:g} Hz, the cards' {cards.sample_rate:g} Hz")


def _rests(trial: CardsOnTrial, cards: Cards) -> None:
    drive = np.full(round(DRIVE_SECONDS * cards.sample_rate), trial.peak)
    cards.sweep(drive)
    _at_rest(trial, "a drive that does not end at 0 V")


def _breaks_off(trial: CardsOnTrial, cards: Cards) -> None:
    def stop() -> None:
        raise KeyboardInterrupt

    try:
        cards.sweep(np.full(round(2.0 * cards.sample_rate), trial.peak), stop)
    except KeyboardInterrupt:
        _at_rest(trial, "a drive broken off")
        return
    raise Failed("a drive cannot be broken off: check was not called, or what it raised was swallowed")


def _refuses(trial: CardsOnTrial, cards: Cards) -> None:
    drive = _drive(trial, cards)
    for wrong, what in (
        (drive * 1.5 * trial.output_range / trial.peak, f"a drive beyond output_range, {trial.output_range:g} V,"),
        (np.where(np.arange(drive.size) == 7, np.nan, drive), "a drive with a NaN"),
        (drive[None], "a drive of two dimensions"),
    ):
        try:
            cards.sweep(wrong)
        except ValueError:
            _at_rest(trial, what)
            continue
        raise Failed(f"{what} was played; ValueError required")


def _temperatures(trial: CardsOnTrial, cards: Cards) -> None:
    readings = cards.temperatures()
    if readings.ndim != 1 or (readings.size > 0) != trial.thermocouples:
        wired = "are" if trial.thermocouples else "are not"
        raise Failed(f"thermocouples {wired} declared, and readings of shape {readings.shape} come")


def _lost(trial: CardsOnTrial, cards: Cards) -> None:
    trial.lose(True)
    try:
        cards.sweep(_drive(trial, cards))
    except DaqError as error:
        if not error.next_step:
            raise Failed(f"its error does not say what to do: {error}") from error
    else:
        raise Failed("the cards are gone, and a sweep came back")
    finally:
        trial.lose(False)


def _closes_twice(trial: CardsOnTrial, cards: Cards) -> None:
    cards.sweep(_drive(trial, cards))
    cards.close()
    _at_rest(trial, "closing")


CHECKS = (
    ("opens with the output at 0 V", "whoever was there before may have left a voltage", _opens),
    ("plays and records", "as many samples come back as were played", _plays),
    ("0 V after every drive", "a standing voltage depolarises a patch", _rests),
    ("a drive can be broken off", "Ctrl-C must not wait for a sweep's end", _breaks_off),
    ("wrong drives are refused", "a drive beyond output_range may damage the patch", _refuses),
    ("thermocouples as declared", "sweeps may be triggered by them", _temperatures),
    ("lost cards are reported", "a campaign searches for them, and ends at rest", _lost),
    ("closes twice, at 0 V", "every way out closes them", _closes_twice),
)


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
