"""What a bad line may not do to a driver that reads a temperature: the same for ovens and thermometers."""

import math
from collections.abc import Callable
from dataclasses import dataclass

from drivers.checks.faulty_line import FaultyLine, LineFault
from drivers.checks.trial import Failed, NotChecked
from drivers.clock import Clock
from drivers.ovens.error import OvenError

FAULTS = (
    (LineFault.SILENCE, math.inf, "a dead line must end a campaign, not be taken for a temperature"),
    (LineFault.GARBAGE, math.inf, "noise on the cable must never pass for a temperature"),
    (LineFault.LATE, 2, "an answer after its time-out must not be taken for the next one's"),
    (LineFault.STALE, 3, "bytes left over from an earlier question must not answer this one"),
    (LineFault.ECHO, math.inf, "many RS-485 adapters return each question before its answer"),
    (LineFault.ERROR, math.inf, "a refusal must be reported, not read as a number"),
    (LineFault.GONE, math.inf, "a pulled cable is reported, and the driver works again once it is back"),
)


@dataclass(frozen=True)
class Reader:
    """A driver on a line that can be made to fail.

    Attributes
    ----------
    read : callable
        Returns the temperature, degrees Celsius.
    truth : callable
        What it may return, degrees Celsius.
    tolerance : float
        K.
    line : FaultyLine
    clock : Clock
    """

    read: Callable[[], float]
    truth: Callable[[], float]
    tolerance: float
    line: FaultyLine
    clock: Clock

    def right(self) -> None:
        """Raise Failed unless the temperature reads right."""
        self._hold(self.read())

    def bears(self, fault: LineFault, questions: float = math.inf, times: int = 4) -> None:
        """Bring a fault on the line, read, then mend the line and read once more.

        Parameters
        ----------
        questions : float
            How many questions meet the fault; infinite: all until the line is mended.
        times : int
            Temperatures read under the fault, a second apart.

        Raises
        ------
        Failed
            If a temperature is wrong, an OvenError has no advice, a reading hides a lasting fault, or
            the fault goes on once the line is mended.
        NotChecked
            If the driver has asked nothing over this line.
        """
        if self.line.questions == 0:
            raise NotChecked("the driver does not use the line it is given")
        self.line.fail(fault, questions)
        reported = 0
        for _ in range(times):
            try:
                self._hold(self.read())
            except OvenError as error:
                reported += 1
                if not error.advice:
                    raise Failed(f"its error has no advice: {error}") from error
            self.clock.sleep(1.0)
        lasting = fault in (LineFault.SILENCE, LineFault.GARBAGE, LineFault.GONE, LineFault.ERROR)
        if math.isinf(questions) and lasting and reported < times:
            raise Failed(f"{fault} all the time, and still {times - reported} of {times} temperatures came back")
        self.line.mend()
        self.clock.sleep(2.0)
        try:
            self.right()
        except OvenError as error:
            raise Failed(f"the line works again, and it reports: {error}") from error

    def _hold(self, value: float) -> None:
        truth = self.truth()
        if not abs(value - truth) <= self.tolerance:
            raise Failed(f"it returned {value:.2f} °C; {truth:.2f} ± {self.tolerance:g} °C is true")
