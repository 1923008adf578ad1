"""What every driver of an oven has to bear."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from drivers.checks.faulty_line import FaultyLine, LineFault
from drivers.checks.line_checks import FAULTS, Reader
from drivers.checks.trial import Check, Failed, NotChecked
from drivers.clock import Clock
from drivers.ovens.error import OvenError
from drivers.ovens.oven import Oven, OvenLimits


@dataclass(frozen=True)
class OvenOnTrial:
    """An oven to which checks may send any query and command within its limits.

    Attributes
    ----------
    open : callable
        Opens it anew on a line.
    line : callable
        Makes such a line.
    clock : Clock
    truth : callable
        Air temperature, degrees Celsius.
    tolerance : float
        Of readings, K.
    limits : OvenLimits
    reach : float
        How far it may be sent from its present temperature, K.
    at_rest : callable
        Whether it neither heats nor cools; raises NotChecked where only the driver could say so.
    lock : callable
        Makes it take no command (True) or take them again; raises NotChecked where that cannot be.
    """

    open: Callable[[FaultyLine], Oven]
    line: Callable[[], FaultyLine]
    clock: Clock
    truth: Callable[[], float]
    tolerance: float
    limits: OvenLimits
    reach: float
    at_rest: Callable[[], bool]
    lock: Callable[[bool], None]


def oven_checks(trial: OvenOnTrial) -> list[Check]:
    """Return all checks, the plainest first; each ends with the oven brought to rest."""
    checks = [Check("opens, and moves nothing", "an oven in use may be looked at", lambda: _opens(trial))]
    checks += [Check(name, why, partial(_rested, trial, what)) for name, why, what in PLAIN]
    checks += [
        Check(str(fault), why, partial(_rested, trial, _bears, fault, questions))
        for fault, questions, why in FAULTS
    ]
    checks += [Check(name, why, partial(_rested, trial, what)) for name, why, what in COMMANDS]
    return [*checks, Check("closes twice, then reports it", "every way out closes it", lambda: _closes(trial))]


def _rested(trial: OvenOnTrial, what: Callable[..., None], *more: object) -> None:
    """Open, do it, and see the oven rest through a line that is sound again, whatever came of it."""
    line = trial.line()
    oven = trial.open(line)
    try:
        what(trial, oven, line, *more)
    finally:
        line.mend()
        try:
            _rest(trial, oven)
        finally:
            oven.close()


def _rest(trial: OvenOnTrial, oven: Oven) -> None:
    oven.safe()
    try:
        resting = trial.at_rest()
    except NotChecked:
        return  # the driver reads back what it wrote; nothing else can be known of a real oven
    if not resting:
        raise Failed("it reported no error when brought to rest, and continues")


def _opens(trial: OvenOnTrial) -> None:
    line = trial.line()
    oven = trial.open(line)
    try:
        if not trial.at_rest():
            raise Failed("opening it started it")
    finally:
        oven.close()


def _reads(trial: OvenOnTrial, oven: Oven, line: FaultyLine) -> None:
    _reader(trial, oven, line).right()
    if not oven.poll_within > 0.0:
        raise Failed(
            f"poll_within is {oven.poll_within!r}; above 0 s allowed, infinity where it need not be polled"
        )


def _ramps(trial: OvenOnTrial, oven: Oven, line: FaultyLine) -> None:
    start, rate = trial.truth(), min(1.0, trial.limits.max_rate)
    end = trial.limits.clamp_target(start + trial.reach)
    taken = oven.ramp_to(end, rate)
    if abs(taken.target - end) > 0.6 or not 0.0 < taken.rate <= 1.05 * rate:
        raise Failed(
            f"asked for {end:g} °C at {rate:g} K/min, it took {taken.target:g} °C at {taken.rate:g} K/min"
        )
    for _ in range(round(12.0 * min(abs(end - start), 4.0) / rate)):
        trial.clock.sleep(5.0)
        _reader(trial, oven, line).right()
    held = oven.hold()
    if not min(start, end) - 1.0 <= held <= max(start, end) + 1.0:
        raise Failed(f"a ramp from {start:.1f} to {end:.1f} °C was held at {held:.1f} °C")


def _rests_twice(trial: OvenOnTrial, oven: Oven, line: FaultyLine) -> None:
    oven.ramp_to(trial.truth() + trial.reach, 1.0)
    _rest(trial, oven)
    _rest(trial, oven)


def _limited(trial: OvenOnTrial, oven: Oven, line: FaultyLine) -> None:
    for asked in (trial.limits.maximum + 500.0, trial.limits.minimum - 500.0):
        taken = oven.ramp_to(asked, 1e3)
        low, high = trial.limits.minimum - 0.6, trial.limits.maximum + 0.6
        if not low <= taken.target <= high or taken.rate > 1.05 * trial.limits.max_rate:
            raise Failed(f"asked for {asked:g} °C at 1000 K/min, it took {taken.target:g} at {taken.rate:g}")


def _no_nonsense(trial: OvenOnTrial, oven: Oven, line: FaultyLine) -> None:
    for target, rate in ((math.nan, 1.0), (30.0, 0.0), (30.0, -1.0), (30.0, math.nan)):
        try:
            oven.ramp_to(target, rate)
        except ValueError:
            continue
        raise Failed(f"a ramp to {target:g} °C at {rate:g} K/min was accepted; ValueError required")


def _bears(trial: OvenOnTrial, oven: Oven, line: FaultyLine, fault: LineFault, questions: float) -> None:
    oven.ramp_to(trial.truth() + trial.reach, 1.0)  # so that a set-point taken for a temperature is seen
    _reader(trial, oven, line).bears(fault, questions)


def _one_glitch(trial: OvenOnTrial, oven: Oven, line: FaultyLine) -> None:
    _require_line(oven, line)
    end = trial.limits.clamp_target(trial.truth() + trial.reach)
    for fault in (LineFault.SILENCE, LineFault.GARBAGE):
        line.fail(fault, 1)
        try:
            taken = oven.ramp_to(end, 1.0)
        except OvenError as error:
            raise Failed(f"one answer lost to {fault}, and the ramp with it: {error}") from error
        if abs(taken.target - end) > 0.6:
            raise Failed(f"asked for {end:g} °C, it took {taken.target:g} °C")


def _refused_ramp(trial: OvenOnTrial, oven: Oven, line: FaultyLine) -> None:
    _require_line(oven, line)
    line.fail(LineFault.ERROR)
    try:
        oven.ramp_to(trial.truth() + trial.reach, 1.0)
    except OvenError:
        return
    raise Failed("every answer was a refusal, and the ramp counts as accepted")


def _locked(trial: OvenOnTrial, oven: Oven, line: FaultyLine) -> None:
    trial.lock(True)
    try:
        oven.ramp_to(trial.truth() + trial.reach, 0.5)
    except OvenError:
        return
    finally:
        trial.lock(False)
    raise Failed("the controller forgot the command, and the ramp counts as taken")


def _interrupted(trial: OvenOnTrial, oven: Oven, line: FaultyLine) -> None:
    _require_line(oven, line)
    oven.ramp_to(trial.truth() + trial.reach, 1.0)
    line.fail(LineFault.INTERRUPTED, 1)
    try:
        oven.temperature()
    except KeyboardInterrupt:
        _rest(trial, oven)
        _reader(trial, oven, line).right()
        return
    raise Failed("Ctrl-C was swallowed")


def _rests_unanswered(trial: OvenOnTrial, oven: Oven, line: FaultyLine) -> None:
    _require_line(oven, line)
    oven.ramp_to(trial.truth() + trial.reach, 1.0)
    line.fail(LineFault.SILENCE)
    try:
        oven.safe()
    except OvenError:
        if not trial.at_rest():
            raise Failed("its commands arrive, only the answers do not, and it continues") from None
        return
    raise Failed("no answer came, and it reported no error when brought to rest")


def _closes(trial: OvenOnTrial) -> None:
    oven = trial.open(trial.line())
    oven.close()
    oven.close()
    try:
        oven.temperature()
    except OvenError:
        return
    raise Failed("closed, it still returns a temperature; OvenError required")


def _require_line(oven: Oven, line: FaultyLine) -> None:
    oven.temperature()
    if line.questions == 0:
        raise NotChecked("the driver does not use the line it is given")


def _reader(trial: OvenOnTrial, oven: Oven, line: FaultyLine) -> Reader:
    return Reader(oven.temperature, trial.truth, trial.tolerance, line, trial.clock)


PLAIN = (
    ("reads the temperature", "sweeps are triggered by it", _reads),
    ("ramps, holds, and rests", "that is all a campaign asks of it", _ramps),
    ("rest may be requested twice", "every end of a campaign requests it", _rests_twice),
    ("set-points stay within limits", "a slip in a file must not heat the plate beyond them", _limited),
    ("nonsense is refused", "NaN, or a rate of 0, mean no ramp at all to many controllers", _no_nonsense),
)
COMMANDS = (
    ("one lost answer costs no set-point", "lines lose an answer now and then", _one_glitch),
    ("a refused ramp is reported", "a campaign would wait for what never comes", _refused_ramp),
    ("settings not accepted are reported", "with a locked panel the oven continues its ramp", _locked),
    ("rests after Ctrl-C in a question", "the answer still owed must not spoil the rest", _interrupted),
    ("rests without any answer", "a broken wire may still carry the commands", _rests_unanswered),
)
