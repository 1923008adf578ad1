"""Samples of a running input task, computed when they are read."""

import zlib

import numpy as np
from nidaqmx.error_codes import DAQmxErrors
from numpy.typing import NDArray
from scipy.signal import butter, lfilter, oaconvolve

from drivers.ni.modules import InputModule, ThermocoupleModule
from drivers.ni.simulated.chassis import Chassis
from drivers.ni.simulated.faults import DaqmxStatusError
from drivers.ni.simulated.task import Task, TaskChannel

IEPE_BIAS = 12.0
"""Voltage on which a sensor that is fed puts its signal, V; it comes with the supply, when a task begins."""
_COUPLING_MEMORY = 1.6
"""How long a coupling capacitor is followed back, over its corner frequency: to 4e-5 of the past."""


_BETA = 8.0
"""Kaiser window of the delay's filter: flat within 0.01 dB to 0.45 of the rate."""


def delay_taps(module: InputModule, sample_rate: float) -> NDArray[np.float64]:
    """Return the causal filter that stands for the module's decimation filter.

    A sinc, shifted by the module's delay and windowed around its centre, so that it never looks
    ahead: the delay of a 9234 is 38.4 samples and a little, not a whole number.

    Returns
    -------
    (L,) ndarray
    """
    delay = module.delay(sample_rate) * sample_rate
    half = np.floor(delay)
    offset = np.arange(2 * int(half) + 1) - delay
    inside = np.clip(1.0 - (offset / (half + 1.0)) ** 2, 0.0, None)
    taps = np.sinc(offset) * np.i0(_BETA * np.sqrt(inside)) / np.i0(_BETA)
    return np.asarray(taps / taps.sum())


def coupled(volts: NDArray[np.float64], corner: float, sample_rate: float) -> NDArray[np.float64]:
    """Return what passes a coupling capacitor that has been on 0 V before: a high-pass of first order.

    Parameters
    ----------
    volts : (..., M) ndarray
        V.
    corner : float
        Frequency of 3 dB attenuation, Hz.
    sample_rate : float
        Hz.

    Returns
    -------
    (..., M) ndarray
        V.
    """
    numerator, denominator = butter(1, corner, btype="highpass", fs=sample_rate)
    return np.asarray(lfilter(numerator, denominator, volts, axis=-1))


def delayed(volts: NDArray[np.float64], module: InputModule, sample_rate: float) -> NDArray[np.float64]:
    """Return voltages as they come out of the module's filter, 0 V before the first.

    Parameters
    ----------
    volts : (C, M) ndarray
        V.
    sample_rate : float
        Hz.

    Returns
    -------
    (C, M) ndarray
        V; late by the module's delay, see `delay_taps`.
    """
    taps = delay_taps(module, sample_rate)
    return np.asarray(oaconvolve(volts, taps[None], axes=1)[:, : volts.shape[1]])


def digitised(volts: NDArray[np.float64], module: InputModule, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return voltages with the module's noise, clipped at its full scale, rounded to its codes.

    Parameters
    ----------
    volts : (C, M) ndarray
        V.
    rng : numpy.random.Generator
        Of the noise.

    Returns
    -------
    (C, M) ndarray
        V; whole multiples of the module's quantum.
    """
    # Drawn sample by sample, not channel by channel: a longer record then begins like a shorter one.
    noisy = volts + module.noise * rng.standard_normal(volts.shape[::-1]).T
    codes = np.clip(np.round(noisy / module.quantum), -(2 ** (module.bits - 1)), 2 ** (module.bits - 1) - 1)
    return np.asarray(codes * module.quantum)


class InputRecorder:
    """Computes what the input modules record.

    A finite task is computed in one piece at its first read, a continuous one second by second, each
    piece preceded by what the plate remembers. So the samples do not depend on how they are read.

    Parameters
    ----------
    chassis : Chassis
    seed : int
        Of the noise. Noise depends on it, on the moment a task began and on its terminals, not on
        what was recorded before: a campaign that is interrupted and resumed meets the same noise.
    """

    def __init__(self, chassis: Chassis, seed: int) -> None:
        self._chassis = chassis
        self._seed = seed

    def samples(self, task: Task, first: int, count: int) -> NDArray[np.float64]:
        """Return samples `first` to `first + count` of every channel.

        Parameters
        ----------
        task : Task
            Has begun and has a sample clock.
        first : int
            Number of the first sample, counted from 0 where the task began.

        Returns
        -------
        (C, count) ndarray
            In each channel's unit: V, degrees Celsius, or what `volts_per_unit` makes of the voltage.
        """
        timing = task.clocked()
        length = timing.samples if timing.finite else max(1, round(timing.rate))
        wanted = range(first // length, (first + max(count, 1) - 1) // length + 1)
        for old in [number for number in task.pieces if number < wanted.start]:
            del task.pieces[old]
        pieces = np.concatenate([self._piece(task, number, length) for number in wanted], axis=1)
        offset = first - wanted.start * length
        return np.asarray(pieces[:, offset : offset + count])

    def _piece(self, task: Task, number: int, length: int) -> NDArray[np.float64]:
        surroundings = self._chassis.surroundings
        if surroundings.hammer is not None:
            version = surroundings.hammer.version
        else:
            version = self._chassis.lines[surroundings.output].version
        known = task.pieces.get(number)
        if known is not None and known[0] == version:
            return known[1]
        computed = self._record(task, number, length)
        task.pieces[number] = (version, computed)
        return computed

    def _record(self, task: Task, number: int, length: int) -> NDArray[np.float64]:
        surroundings, rate = self._chassis.surroundings, task.clocked().pace
        if task.began is None:
            raise ValueError(f"task {task.name} has not begun: it has no samples yet")
        lead = int(np.ceil(self._memory(task, rate) * rate))
        moments = task.began + np.arange(number * length - lead, (number + 1) * length) / rate
        if surroundings.hammer is not None:
            drive, answer = surroundings.hammer(moments, rate)
        else:
            drive = self._chassis.lines[surroundings.output].voltages(moments)
            if not np.any(drive[:lead]):
                # A plate at rest needs no history, and a sweep is then computed just as it was played.
                drive, moments, lead = drive[lead:], moments[lead:], 0
            answer = self._answer(task, drive, rate, moments)
        identity = zlib.crc32(",".join(channel.terminal for channel in task.channels).encode())
        rng = np.random.default_rng([self._seed, round(task.began * 1e6), number, identity])
        recorded = np.empty((len(task.channels), length))
        for module in dict.fromkeys(channel.module for channel in task.channels):
            rows = [row for row, channel in enumerate(task.channels) if channel.module == module]
            if isinstance(module, InputModule):
                volts = np.stack([self._at(task.channels[row], drive, answer, rate) for row in rows])
                arrived = delayed(volts, module, rate)[:, lead:]
                recorded[rows] = digitised(arrived, module, rng)
            elif isinstance(module, ThermocoupleModule):
                # Asked faster than it converts, it gives each conversion again until the next is there.
                duration = module.duration(len(rows))
                held = task.began + duration * np.floor((moments[lead:] - task.began) / duration + 1e-6)
                _, conversion = np.unique(held, return_inverse=True)
                for row in rows:
                    noise = module.noise * rng.standard_normal(conversion.max() + 1)
                    recorded[row] = self.temperature(task.channels[row], held) + noise[conversion]
        recorded /= np.array([channel.volts_per_unit for channel in task.channels])[:, None]
        return recorded

    def _answer(
        self, task: Task, drive: NDArray[np.float64], rate: float, moments: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return the plate's response (K, M); it is not computed at rest, or if no input is read."""
        surroundings = self._chassis.surroundings
        if not any(channel.terminal in surroundings.sensors for channel in task.channels):
            return np.empty((0, drive.size))
        if not drive.any():  # at rest
            return np.zeros((1 + max(surroundings.sensors.values()), drive.size))
        temperature = surroundings.plate_temperature(moments)
        answer = np.asarray(surroundings.plate(drive, rate, temperature), dtype=np.float64)
        if answer.ndim != 2 or answer.shape[1] != drive.size:
            raise ValueError(f"the plate answered with shape {answer.shape}; (K, {drive.size}) wanted")
        return answer

    def _memory(self, task: Task, rate: float) -> float:
        """Return how far back a sample looks, s: plate or coupling, and behind them the module's filter."""
        filters, corners = [0.0], []
        for channel in task.channels:
            if isinstance(channel.module, InputModule):
                filters.append(2.0 * channel.module.delay(rate))
                corners += [channel.module.coupling_corner] if channel.ac_coupled else []
        signals = [self._chassis.surroundings.memory, *(_COUPLING_MEMORY / corner for corner in corners)]
        return max(signals) + max(filters)

    def _at(
        self, channel: TaskChannel, drive: NDArray[np.float64], answer: NDArray[np.float64], rate: float
    ) -> NDArray[np.float64]:
        """Voltage on an input's terminal, behind its coupling."""
        surroundings = self._chassis.surroundings
        if channel.terminal in self._chassis.faults.dead_inputs:
            volts = np.zeros_like(drive)
        elif channel.terminal in surroundings.drive_inputs:
            volts = drive if surroundings.hammer is not None else surroundings.drive_scale * drive
        elif channel.terminal in surroundings.sensors:
            volts = answer[surroundings.sensors[channel.terminal]]
        else:
            volts = np.zeros_like(drive)
        if channel.terminal in surroundings.iepe_sensors:
            volts = volts + IEPE_BIAS if channel.feeds else np.zeros_like(drive)
        if channel.ac_coupled and isinstance(channel.module, InputModule):
            return coupled(volts, channel.module.coupling_corner, rate)
        return volts

    def temperature(self, channel: TaskChannel, moments: NDArray[np.float64]) -> NDArray[np.float64]:
        """Temperature a thermocouple's tip has at moments (M,), degrees Celsius."""
        surroundings = self._chassis.surroundings
        touched = surroundings.thermocouples.get(channel.terminal, surroundings.plate_temperature)
        return np.asarray(touched(moments), dtype=np.float64)

    def read_now(self, task: Task) -> NDArray[np.float64]:
        """Convert every channel once, (C,), taking the time that a thermocouple module needs for that."""
        readings = np.empty(len(task.channels))
        for row, channel in enumerate(task.channels):
            module = channel.module
            if isinstance(module, ThermocoupleModule):
                self._chassis.pass_time_to(self._chassis.clock.now() + module.duration(1))
            elif not (isinstance(module, InputModule) and module.on_demand):
                raise DaqmxStatusError(
                    DAQmxErrors.INVALID_ATTRIBUTE_VALUE,
                    f"{module.name} does not support on-demand timing. Task Name: {task.name}",
                )
            moment = self._chassis.clock.now()
            rng = np.random.default_rng([self._seed, round(moment * 1e6), zlib.crc32(channel.terminal.encode())])
            if isinstance(module, ThermocoupleModule):
                value = self.temperature(channel, np.array([moment]))[0]
                readings[row] = value + module.noise * rng.standard_normal()
            elif isinstance(module, InputModule):
                readings[row] = digitised(self._voltage(channel, moment), module, rng)[0, 0]
        return readings

    def _voltage(self, channel: TaskChannel, moment: float) -> NDArray[np.float64]:
        """Return what is on a terminal now, (1, 1): of a plate at rest nothing, of the drive what it is."""
        surroundings = self._chassis.surroundings
        if channel.terminal not in surroundings.drive_inputs:
            return np.zeros((1, 1))
        return np.array([[surroundings.drive_scale * self._chassis.lines[surroundings.output].voltage(moment)]])
