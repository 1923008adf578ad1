"""A stand-in for the package ``sounddevice``: a sound card with a plate between output and inputs."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real
from drivers.clock import Clock
from drivers.ni.simulated.surroundings import DrivenPlate, Temperature, room

CODES = 2.0**23


class PortAudioError(Exception):
    """What the package raises where PortAudio refuses."""


@dataclass
class SimulatedSound:
    """Plays and records as the package's functions of the same names do, on a clock that is handed in.

    Attributes
    ----------
    plate : DrivenPlate
    clock : Clock
    inputs : mapping of int to int
        Input channel, from 1, -> row of the plate's answer; -1 is the loop-back cable.
    output_range, input_range : float
        True voltage of a sample of 1, V.
    drive_scale : float
        Volts at the drive's input per volt of the output: 1 of a cable.
    temperature : callable
        Of the plate.
    seed : int
        Of the noise.
    noise : float
        Of an input, V rms.
    latency : float
        Samples from output to input; some more in every other stream, as buffers happen to lie.
    xruns : list of int
        Numbers of the streams, from 1, in which samples are lost.
    gone : bool
        Whether the device has been pulled out.
    """

    plate: DrivenPlate
    clock: Clock
    inputs: Mapping[int, int]
    output_range: float
    input_range: float
    drive_scale: float = 1.0
    temperature: Temperature = room
    seed: int = 0
    noise: float = 2e-5
    latency: float = 1234.0
    xruns: list[int] = field(default_factory=list)
    gone: bool = False
    streams: int = 0
    PortAudioError = PortAudioError

    def __post_init__(self) -> None:
        self._ends = -1.0
        self._began = 0.0
        self._volts: Real = np.zeros(1)
        self._rate = 1.0

    def playrec(
        self,
        data: NDArray[np.float32],
        samplerate: float,
        dtype: str,
        input_mapping: list[int],
        output_mapping: list[int],
        device: str | None,
        latency: str,
    ) -> NDArray[np.float32]:
        """Return at once what is going to be recorded while `data` is played.

        Parameters
        ----------
        data : (M, 1) ndarray
            Samples from -1 to 1, `output_range` each.
        samplerate : float
            Hz.
        dtype : str
            Of the samples returned.
        input_mapping : (C,) list of int
            Input channels to record, from 1.
        output_mapping : list of int
            Not used: there is one output.
        device : str or None
            Not used: there is one device.
        latency : str
            Not used: the attribute of the same name holds.

        Returns
        -------
        (M, C) ndarray
            Samples from -1 to 1, `input_range` each.

        Raises
        ------
        PortAudioError
            If the device is gone, or has no such input.
        """
        if self.gone:
            raise PortAudioError("Error opening Stream: Device unavailable [PaErrorCode -9985]")
        missing = sorted(set(input_mapping) - set(self.inputs))
        if missing:
            raise PortAudioError(f"Error opening Stream: Invalid number of channels [PaErrorCode -9998] {missing}")
        self.streams += 1
        drive = np.clip(np.asarray(data[:, 0], dtype=np.float64), -1.0, 1.0) * self.output_range
        now = self.clock.now()
        self._began, self._rate, self._volts = now, samplerate, drive
        self._ends = now + drive.size / samplerate
        moments = now + np.arange(drive.size) / samplerate
        rows = [self.inputs[channel] for channel in input_mapping]
        signals = np.zeros((len(rows), drive.size))
        if drive.any():
            answer = self.plate(drive, samplerate, self.temperature(moments))
            signals = np.stack([self.drive_scale * drive if row < 0 else answer[row] for row in rows])
        late, part = divmod(self.latency, 1.0)
        turned = np.fft.rfft(signals) * np.exp(-2j * np.pi * part * np.fft.rfftfreq(drive.size))
        signals = np.fft.irfft(turned, drive.size)
        late = int(late) + 17 * (self.streams % 2)
        arrived = np.pad(signals, ((0, 0), (late, 0)))[:, : drive.size]
        rng = np.random.default_rng([self.seed, round(now * 1e6)])
        arrived = arrived + self.noise * rng.standard_normal(arrived.shape)
        if self.streams in self.xruns:
            half = drive.size // 2
            arrived[:, half:] = np.roll(arrived[:, half:], -256, axis=1)
        codes = np.round(np.clip(arrived / self.input_range, -1.0, 1.0 - 1.0 / CODES) * CODES)
        return np.asarray((codes / CODES).T, dtype=dtype)

    def get_stream(self) -> "SimulatedSound":
        """Return the stream under way, which this object stands for as well."""
        return self

    @property
    def active(self) -> bool:
        """Whether it still plays."""
        return self.clock.now() < self._ends

    def get_status(self) -> str:
        """Return which flags the stream raised; empty for none."""
        return "input overflow" if self.streams in self.xruns else ""

    def stop(self, ignore_errors: bool = True) -> None:
        """End what is played: an output that plays nothing is at 0 V."""
        self._ends = min(self._ends, self.clock.now())

    def voltage(self) -> float:
        """Voltage on the output now, V."""
        index = int((self.clock.now() - self._began) * self._rate)
        return float(self._volts[index]) if self.active and index < self._volts.size else 0.0


def simulated_sound(settings: Any, plate: DrivenPlate, clock: Clock, **others: Any) -> SimulatedSound:
    """Return a card wired and calibrated as `settings` declare.

    Parameters
    ----------
    settings : SoundCard
    **others
        Any other attribute of `SimulatedSound`.
    """
    from drivers.soundcard.card import channel_number

    rows = {channel_number(name): row for row, name in enumerate(settings.responses)}
    rows[channel_number(settings.drive_input)] = -1
    return SimulatedSound(plate, clock, rows, settings.output_range, settings.input_range, **others)
