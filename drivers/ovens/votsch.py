"""Vötsch and Weiss chambers over their protocol ASCII-2: text, ended by CR, without a checksum.

``$01?`` describes the chamber's channels and bits, ``$01I`` reads a nominal and an actual value of
each channel and all bits, ``$01E`` writes all nominal values and bits at once, ``$01U`` the
gradients. What cannot be checked by a sum is checked by wording: an answer is taken only if every
character is where the description says.
"""

import math
import re
from dataclasses import dataclass

from drivers.ovens.error import Fault, OvenError
from drivers.ovens.line import Line, up_to
from drivers.ovens.oven import OvenLimits, SetPoint, beyond_ramp, other_set_point

END_OF_DESCRIPTION = 0.3
"""Seconds of silence after which a description, whose length is not transmitted, is complete."""


RESOLUTION = 0.1
"""Of its temperatures, K."""
NAP = 2.0
"""Between two looks at whether a nominal temperature moves, s."""


CR = b"\r"

_NUMBER = r"[-+]?\d{1,5}\.\d"
_CHANNEL = re.compile(r"\s*((?:CV|SV|MV|AV|AO)\d\d)\s+(?!(?:CV|SV|MV|AV|AO|DO)\d\d)(.*)")
_BIT = re.compile(r"\s*DO(\d\d)\s+(?!DO\d\d)(.*)")
_NAMES = re.compile(r"(?:(?:CV|SV|MV|AV|AO|DO)\d\d){4,}")
_RANGE = re.compile(rf"value\s+min:\s*({_NUMBER})\s+value\s+max:\s*({_NUMBER})\s+(.*)", re.IGNORECASE)


@dataclass(frozen=True)
class Ascii2Channel:
    """One analogue channel, in the order of the chamber's strings.

    Attributes
    ----------
    name : str
        ``CV01``, ``SV01``, ``MV01`` …
    label : str
        What the chamber calls it.
    minimum, maximum : float
        Of its nominal value; infinite where the chamber gives none.
    """

    name: str
    label: str
    minimum: float = -math.inf
    maximum: float = math.inf


@dataclass(frozen=True)
class Ascii2Layout:
    """What a chamber's strings hold.

    Attributes
    ----------
    channels : tuple of Ascii2Channel
    bits : tuple of str
        Labels of the digital channels that are written, DO00 first.
    reported : tuple of str
        Names of the channels in the order of the I-string's values: twice (nominal, then actual) or, where only a
        value was set or only one is measured, once; also of channels that are never written. Each of them twice
        where the chamber does not say.
    reported_bits : int
        How many the I-string ends with; by default as many as are written.
    """

    channels: tuple[Ascii2Channel, ...]
    bits: tuple[str, ...]
    reported: tuple[str, ...] = ()
    reported_bits: int = 0

    def __post_init__(self) -> None:
        if not self.reported:
            twice = tuple(channel.name for channel in self.channels for _ in range(2))
            object.__setattr__(self, "reported", twice)
        object.__setattr__(self, "reported_bits", max(self.reported_bits, len(self.bits)))

    @property
    def temperature(self) -> int:
        """Index of the channel that controls the temperature."""
        return self._only(
            [i for i, c in enumerate(self.channels) if c.name.startswith("CV") and "temp" in c.label.lower()],
            "control value named temperature",
        )

    @property
    def start(self) -> int:
        """Index of the bit that starts the chamber."""
        return self._only([i for i, label in enumerate(self.bits) if label.lower() == "start"], "bit named Start")

    @property
    def controls(self) -> int:
        """How many values the chamber controls (temperature, humidity)."""
        return sum(channel.name.startswith("CV") for channel in self.channels)

    def _only(self, found: list[int], what: str) -> int:
        if len(found) != 1:
            raise OvenError(
                Fault.REFUSED,
                f"the chamber describes {len(found)} times a {what}; exactly 1 can be used",
                "Send the answer to $01? to the developers: this layout is new.",
            )
        return found[0]


@dataclass(frozen=True)
class Status:
    """All channels and bits at one time.

    Attributes
    ----------
    nominal, actual : tuple of float
        In the order of the layout.
    bits : str
        ``0`` and ``1``, DO00 first, of those that are written.
    """

    nominal: tuple[float, ...]
    actual: tuple[float, ...]
    bits: str


def decode_description(answer: bytes) -> Ascii2Layout:
    """Return the layout a chamber describes in its answer to ``$01?``."""
    text = answer.decode("latin-1")
    # The part on the E-string comes first; the one on the I-string names most channels twice.
    written, _, read = re.sub("(?i)i-string", "I-STRING", text).partition("I-STRING")
    channels: dict[str, Ascii2Channel] = {}
    bits: dict[int, str] = {}
    for line in written.splitlines():
        if match := _CHANNEL.fullmatch(line):
            name, rest = match[1], match[2].strip()
            ranged = _RANGE.fullmatch(rest)
            channels[name] = (
                Ascii2Channel(name, ranged[3].strip(), float(ranged[1]), float(ranged[2]))
                if ranged
                else Ascii2Channel(name, rest)
            )
        elif match := _BIT.fullmatch(line):
            bits[int(match[1])] = match[2].strip()
    if not channels or sorted(bits) != list(range(len(bits))) or not bits:
        raise OvenError(
            Fault.GARBLED,
            f"no description of channels and bits in {text[:80]!r}",
            "Is the chamber set to the protocol ASCII-2, and is address right?",
        )
    # Names run over several lines, broken anywhere, and may stand without a space between them.
    named = _NAMES.search(re.sub(r"\s", "", read))
    reported = tuple(re.findall(r"(?:CV|SV|MV|AV|AO)\d\d", named[0])) if named else ()
    return Ascii2Layout(
        tuple(channels.values()),
        tuple(bits[i] for i in range(len(bits))),
        reported if set(reported) >= set(channels) else (),
        1 + max((int(number) for number in re.findall(r"DO(\d\d)", read)), default=-1),
    )


def decode_status(answer: bytes, layout: Ascii2Layout) -> Status:
    """Return what ``$01I`` answered."""
    count, bits = len(layout.reported), layout.reported_bits
    match = re.fullmatch(rf"((?:{_NUMBER}\s+){{{count}}})([01]{{{bits}}})\s*", answer.decode("latin-1"))
    if match is None:
        raise garbled(answer, f"{count} values and {bits} bits")
    values: dict[str, list[float]] = {}
    for name, word in zip(layout.reported, match[1].split(), strict=True):
        values.setdefault(name, []).append(float(word))
    of_channels = [values[channel.name] for channel in layout.channels]
    written = match[2][: len(layout.bits)]
    return Status(tuple(of[0] for of in of_channels), tuple(of[-1] for of in of_channels), written)


def encode_status(address: int, nominal: tuple[float, ...], bits: str) -> bytes:
    """Return the ``$01E`` string that sets all channels and bits.

    Parameters
    ----------
    address : int
        0 to 99.
    nominal : (C,) tuple of float
        Set-points of the channels in their own units, temperature (degrees Celsius) first; one decimal is sent.
    bits : str
        One ``0`` or ``1`` for each digital channel.

    Returns
    -------
    bytes
        With the carriage return at its end.
    """
    return f"${address:02d}E {_values(nominal)} {bits}\r".encode("ascii")


def encode_gradients(address: int, gradients: tuple[float, ...]) -> bytes:
    """Return the ``$01U`` string: up and down of every controlled value, K/min (temperature first)."""
    return f"${address:02d}U {_values(gradients)}\r".encode("ascii")


def encode_query(address: int, letter: str) -> bytes:
    """Return ``$01?`` or ``$01I``."""
    return f"${address:02d}{letter}\r".encode("ascii")


def decode_acknowledgement(answer: bytes) -> None:
    """Take a ``0`` for done and any other number for a refusal."""
    match = re.fullmatch(rb"(\d{1,3})\s*", answer)
    if match is None:
        raise garbled(answer, "an acknowledgement")
    if int(match[1]) != 0:
        raise OvenError(
            Fault.REFUSED,
            "the chamber refuses the values",
            "Check them against the chamber's own limits, and that it is set to external control.",
            match[1].decode("ascii"),
        )


def garbled(answer: bytes, wanted: str) -> OvenError:
    """Return the error for an answer that is not valid, or for a missing answer."""
    if not answer:
        return OvenError(
            Fault.SILENT,
            "the chamber does not answer",
            "Is it switched on and wired? Check port, address and baud rate, and that it speaks this protocol.",
        )
    return OvenError(
        Fault.GARBLED,
        f"{answer[:60]!r} instead of {wanted}",
        "Check baud rate and parity, the cable's shield and ground, and that nobody else uses this port.",
    )


def _values(numbers: tuple[float, ...]) -> str:
    return " ".join(f"{number:06.1f}" for number in numbers)


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
        self._seen: Status | None = None
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
            self._send(encode_gradients(self._address, (*gradients, *others)))
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
                stopped = encode_status(self._address, self._seen.nominal, bits)
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
                self._send(encode_status(self._address, *wanted))
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

    def _require_under_way(self, before: Status, after: Status, wanted: tuple[tuple[float, ...], str]) -> None:
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

    def _bits(self, status: Status, *, running: bool) -> str:
        """Return the bits of a status with Start on or off."""
        return status.bits[: self._start] + str(int(running)) + status.bits[self._start + 1 :]

    def _others(self, nominal: tuple[float, ...]) -> tuple[float, ...]:
        return nominal[: self._air] + nominal[self._air + 1 :]

    def _status(self) -> Status:
        self._seen = self._line.attempt(
            lambda: decode_status(self._line.exchange(encode_query(self._address, "I"), up_to(CR)), self._layout)
        )
        return self._seen

    def _send(self, request: bytes) -> None:
        self._line.attempt(
            lambda: decode_acknowledgement(self._line.exchange(request, up_to(CR))),
            writes=True,
            checksum=False,
        )

    def _describe(self) -> Ascii2Layout:
        request = encode_query(self._address, "?")
        answer = self._line.exchange(request, lambda _: None, quiet=END_OF_DESCRIPTION)
        if not answer:
            raise garbled(answer, "a description")
        return decode_description(answer)


def _not_taken(wanted: tuple[tuple[float, ...], str], seen: Status) -> OvenError:
    return OvenError(
        Fault.NOT_TAKEN,
        f"set to {_status_text(*wanted)}, the chamber reads back {_status_text(seen.nominal, seen.bits)}",
        "Check the chamber's own limits, that it is under external control, and who uses its panel.",
    )


def _status_text(nominal: tuple[float, ...], bits: str) -> str:
    return f"{' '.join(f'{value:.1f}' for value in nominal)} {bits}"
