"""What every driver of a thermometer has to bear."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from drivers.checks.faulty_line import FaultyLine, LineFault
from drivers.checks.line_checks import FAULTS, Reader
from drivers.checks.trial import Check, Failed
from drivers.clock import Clock
from drivers.ovens.error import OvenError
from drivers.thermometers.thermometer import Thermometer


@dataclass(frozen=True)
class ThermometerOnTrial:
    """A thermometer that checks may ask; attributes as of `OvenOnTrial`."""

    open: Callable[[FaultyLine], Thermometer]
    line: Callable[[], FaultyLine]
    clock: Clock
    truth: Callable[[], float]
    tolerance: float


def thermometer_checks(trial: ThermometerOnTrial) -> list[Check]:
    """Return all checks, the plainest first."""
    checks = [Check("reads the temperature", "sweeps are triggered by it", partial(_opened, trial, _reads))]
    checks += [
        Check(str(fault), why, partial(_opened, trial, _bears, fault, questions))
        for fault, questions, why in FAULTS
    ]
    return [*checks, Check("closes twice, then reports it", "every way out closes it", lambda: _closes(trial))]


def _opened(trial: ThermometerOnTrial, what: Callable[..., None], *more: object) -> None:
    line = trial.line()
    thermometer = trial.open(line)

    def mean() -> float:
        readings = thermometer.temperatures()
        if readings.ndim != 1 or readings.size == 0:
            raise Failed(f"temperatures of shape {readings.shape}; (T,) with T >= 1 allowed")
        return float(np.mean(readings))

    try:
        what(Reader(mean, trial.truth, trial.tolerance, line, trial.clock), *more)
    finally:
        thermometer.close()


def _reads(reader: Reader) -> None:
    reader.right()


def _bears(reader: Reader, fault: LineFault, questions: float = math.inf) -> None:
    reader.bears(fault, questions)


def _closes(trial: ThermometerOnTrial) -> None:
    thermometer = trial.open(trial.line())
    thermometer.close()
    thermometer.close()
    try:
        thermometer.temperatures()
    except OvenError:
        return
    raise Failed("closed, it still returns temperatures; ThermometerError required")
