"""Vötsch and Weiss chambers over ASCII-2."""

import math

from drivers.ovens import ascii2
from drivers.ovens.error import Fault, OvenError
from drivers.ovens.line import Line, up_to
from drivers.ovens.oven import OvenLimits, SetPoint, beyond_ramp, other_set_point

END_OF_DESCRIPTION = 0.3
"""Seconds of silence after which a description, whose length is not transmitted, is complete."""


RESOLUTION = 0.1
"""Of its temperatures, K."""
NAP = 2.0
"""Between two looks at whether a nominal temperature moves, s."""


class Votsch:
    """A chamber that ramps with gradients of its own. Safe state: the bit named Start is off.

    A write replaces every channel and every bit, so each change reads all of them first, alters what
    it means to, and reads them again. The gradients cannot be read back: the protocol has no question
    for them.

    Parameters
    ----------
    line : Line
    address : int
        1 to 32.
    limits : OvenLimits
    """

    poll_within = math.inf

    def __init__(self, line: Line, address: int, limits: OvenLimits) -> None:
        self.limits = limits
        self._line = line
        self._address = address
        self._layout = line.attempt(self._describe)
        self._air = self._layout.temperature
        self._start = self._layout.start
        self._rate = limits.max_rate
        self._seen: ascii2.Status | None = None
        self._told: tuple[float, float] | None = None
        line.blind(self._status)  # a write replaces all channels: `safe` needs them where no answer comes any more

    def temperature(self) -> float:
        """Air temperature, degrees Celsius."""
        return self._status().actual[self._air]

    def bounds(self) -> tuple[float, float]:
        """Limits of the chamber's nominal temperature, as it describes them, degrees Celsius."""
        air = self._layout.channels[self._air]
        return air.minimum, air.maximum

    def ramp_to(self, target: float, rate: float) -> SetPoint:
        """Set the gradients, then nominal temperature and Start.

        Raises
        ------
        ValueError
            For a rate below the 0.1 K/min the protocol can say.
        """
        wanted = self.limits.clamp(target, rate)
        taken_rate = round(wanted.rate, 1)
        if taken_rate == 0.0:
            raise ValueError(f"rate {rate:g} K/min: this chamber's protocol has steps of 0.1 K/min from 0.1")
        others = (0.0,) * (2 * self._layout.controls - 2)
        with self._line.reserved():
            up = wanted.target >= self._status().actual[self._air]
            gradients = (taken_rate, 0.0) if up else (0.0, taken_rate)  # some take only one of them at a time
            self._send(ascii2.encode_gradients(self._address, (*gradients, *others)))
            self._rate = taken_rate
            return SetPoint(self._change(wanted.target, running=True), taken_rate)

    def hold(self) -> float:
        """Make the temperature measured now the nominal one: the chamber does not report the state of its ramp."""
        with self._line.reserved():
            return self._change(self.limits.clamp_target(self.temperature()), running=True)

    def changed(self) -> str:
        """Say whether the Start bit or the nominal temperature are others than commanded.

        Some chambers report where their ramp is as the nominal temperature: all on its way is as commanded.
        """
        if self._told is None:
            return ""
        seen = self._status()
        if seen.bits[self._start] != "1":
            return "it was stopped"
        held = seen.nominal[self._air]
        return other_set_point(self._told[1], held) and beyond_ramp(self._told, held)

    def safe(self) -> None:
        """Take the Start bit away, whatever the channels hold.

        The first write sends the other channels and bits as they were when they were last read.
        """
        with self._line.reserved():
            if self._seen is not None:
                bits = self._bits(self._seen, running=False)
                stopped = ascii2.encode_status(self._address, self._seen.nominal, bits)
                self._line.blind(lambda: self._send(stopped))
            self._change(None, running=False)

    def close(self) -> None:
        """Let go of the line."""
        self._line.close()

    def _change(self, target: float | None, *, running: bool) -> float:
        with self._line.reserved():
            before = self._status()
            nominal = list(before.nominal)
            if target is not None:
                nominal[self._air] = round(target, 1)
            wanted = (tuple(nominal), self._bits(before, running=running))
            if wanted != (before.nominal, before.bits):
                self._send(ascii2.encode_status(self._address, *wanted))
            self._told = None if target is None else (before.actual[self._air], wanted[0][self._air])
            after = self._status()
            if target is None:
                if after.bits != wanted[1]:
                    raise _not_taken(wanted, after)
                return after.nominal[self._air]
            if (self._others(after.nominal), after.bits) != (self._others(wanted[0]), wanted[1]):
                raise _not_taken(wanted, after)
            self._require_under_way(before, after, wanted)
            return wanted[0][self._air]

    def _require_under_way(
        self, before: ascii2.Status, after: ascii2.Status, wanted: tuple[tuple[float, ...], str]
    ) -> None:
        """Raise unless the nominal temperature is as written, or moves there: some chambers report the ramp."""
        target, was = wanted[0][self._air], before.nominal[self._air]
        for _ in range(round(2.0 * 60.0 * RESOLUTION / self._rate / NAP) + 2):
            now = after.nominal[self._air]
            if now == target or abs(now - target) < abs(was - target):
                return
            if before.bits != after.bits and now in (was, before.actual[self._air]):
                return  # started by the same string: its values were taken with its bits
            self._line.pause(NAP)
            after = self._status()
        raise _not_taken(wanted, after)

    def _bits(self, status: ascii2.Status, *, running: bool) -> str:
        """Return the bits of a status with Start on or off."""
        return status.bits[: self._start] + str(int(running)) + status.bits[self._start + 1 :]

    def _others(self, nominal: tuple[float, ...]) -> tuple[float, ...]:
        return nominal[: self._air] + nominal[self._air + 1 :]

    def _status(self) -> ascii2.Status:
        self._seen = self._line.attempt(
            lambda: ascii2.decode_status(
                self._line.exchange(ascii2.encode_query(self._address, "I"), up_to(ascii2.CR)), self._layout
            )
        )
        return self._seen

    def _send(self, request: bytes) -> None:
        self._line.attempt(
            lambda: ascii2.decode_acknowledgement(self._line.exchange(request, up_to(ascii2.CR))),
            writes=True,
            checksum=False,
        )

    def _describe(self) -> ascii2.Ascii2Layout:
        request = ascii2.encode_query(self._address, "?")
        answer = self._line.exchange(request, lambda _: None, quiet=END_OF_DESCRIPTION)
        if not answer:
            raise ascii2.garbled(answer, "a description")
        return ascii2.decode_description(answer)


def _not_taken(wanted: tuple[tuple[float, ...], str], seen: ascii2.Status) -> OvenError:
    return OvenError(
        Fault.NOT_TAKEN,
        f"set to {_status_text(*wanted)}, the chamber reads back {_status_text(seen.nominal, seen.bits)}",
        "Check the chamber's own limits, that it is under external control, and who uses its panel.",
    )


def _status_text(nominal: tuple[float, ...], bits: str) -> str:
    return f"{' '.join(f'{value:.1f}' for value in nominal)} {bits}"
