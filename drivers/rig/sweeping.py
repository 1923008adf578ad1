"""One set-point: sweep, check, limited repetition."""

from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analysis.plate_temperature.resonances import FrfThermometer, log_spectrum
from analysis.protocol.acceptance import faults
from analysis.protocol.protocol import AcquisitionProtocol, SweepSetPoint
from analysis.protocol.sweep import drive_signal
from analysis.recordings.campaign import Sweep
from analysis.recordings.h1 import h1
from drivers.ni.errors import DaqError
from drivers.rig.readings import Reading
from drivers.rig.station import Station
from drivers.rig.store import Store


@dataclass(frozen=True)
class Attempt:
    """Result of one attempt.

    Attributes
    ----------
    sweep : Sweep or None
        None if there is no complete record.
    faults : tuple of str
        Why it is rejected; empty for a good sweep.
    may_repeat : bool
        Whether another attempt may succeed.
    """

    sweep: Sweep | None
    faults: tuple[str, ...]
    may_repeat: bool = True


class Sweeping:
    """Makes the sweeps of a campaign.

    Parameters
    ----------
    station : Station
    protocol : AcquisitionProtocol
    store : Store
    attempts : dict of int to int
        Attempts made so far, by step, including those before an interruption.
    doubted : set of int
        Steps of finished sweeps whose temperature is in doubt.
    """

    def __init__(
        self,
        station: Station,
        protocol: AcquisitionProtocol,
        store: Store,
        attempts: dict[int, int],
        doubted: Collection[int] = (),
    ) -> None:
        self._station = station
        self._protocol = protocol
        self._store = store
        self._attempts = attempts
        self._thermometer = FrfThermometer()
        for sweep in store.sweeps():
            station.check()
            self._by_resonances(sweep, doubted=sweep.step in doubted)

    def attempt(self, set_point: SweepSetPoint) -> Attempt:
        """Make one attempt; store a good sweep, put a faulty one aside.

        Raises
        ------
        DaqError
            If the cards are lost, or refuse in a way that repeating does not cure.
        RigStopped
            If the oven or a temperature requires a stop.
        OSError
            If the sweep cannot be written.
        """
        number = self._attempts.get(set_point.step, 0) + 1
        self._attempts[set_point.step] = number
        self._station.note("sweep begun", step=set_point.step, place=str(set_point), attempt=number)
        try:
            made = self._make(set_point)
        except DaqError as error:
            if error.action.retries == 0:
                raise
            made = Attempt(None, (str(error),), may_repeat=number <= error.action.retries)
        what = {"step": set_point.step, "place": str(set_point), "attempt": number}
        if made.sweep is not None and not made.faults:
            self._store.keep(made.sweep, set_point, number)
            self._station.mark(set_point.step)
            doubt = {"doubt": made.sweep.doubt} if made.sweep.doubt else {}
            self._station.note("finished", **what, temperature=round(made.sweep.temperature, 4), **doubt)
            return made
        if made.sweep is not None:
            self._store.put_aside(made.sweep, set_point, number, made.faults)
        self._station.note("rejected", **what, faults=list(made.faults))
        return made

    def _make(self, set_point: SweepSetPoint) -> Attempt:
        station, sweep = self._station, self._protocol.sweep
        rate = station.sample_rate
        drive = drive_signal(sweep, set_point.level, rate)
        before, began = station.reading(), station.date()
        if before is None:
            return Attempt(None, ("no temperature before the sweep",))
        drives, responses, overloaded = [], [], np.zeros(0, dtype=bool)
        readings = [before]
        for repeat in range(sweep.repeats):
            if repeat:  # the oven is read at least once per repeat
                between = station.reading()
                if between is None:
                    return Attempt(None, (f"no temperature before repeat {repeat + 1}",))
                readings.append(between)
            record = station.play(drive)
            self._store.show(record, set_point, repeat)
            if record.drive.shape != drive.shape:
                fault = f"repeat {repeat + 1}: {record.drive.size} samples came, {drive.size} were played"
                return Attempt(None, (fault,))
            drives.append(record.drive.astype(np.float32))
            responses.append(record.responses.astype(np.float32))
            overloaded = record.overloaded if not repeat else overloaded | record.overloaded
        after = station.reading()
        if after is None:
            return Attempt(None, ("no temperature after the sweep",))
        made = _sweep(set_point, [*readings, after], began, drives, responses)
        wrong = faults(made, drive, overloaded, rate, set_point, self._protocol)
        if not wrong:
            contradicted = self._by_resonances(made, doubted=bool(made.doubt))
            made = replace(made, doubt="; ".join(filter(None, (made.doubt, contradicted))))
        return Attempt(made, wrong)

    def _by_resonances(self, sweep: Sweep, *, doubted: bool) -> str:
        """Return what the resonances of a good sweep say against the reading of the plate's sensor."""
        if sweep.plate_temperature_start is None:
            return ""
        frequency = np.fft.rfftfreq(sweep.drive.shape[1], 1.0 / self._station.sample_rate).astype(np.float64)
        low, high = self._protocol.sweep.band
        inside = (frequency >= low) & (frequency <= high)
        if inside.sum() < 2:
            return ""
        h = np.array([h1(sweep.drive, response)[0][inside] for response in sweep.responses])
        spectrum = log_spectrum(frequency[inside], h)
        return self._thermometer.judge(
            sweep.level, sweep.temperature, spectrum, doubted=doubted or bool(sweep.doubt)
        )


def _sweep(
    set_point: SweepSetPoint,
    readings: list[Reading],
    began: str,
    drives: list[NDArray[np.float32]],
    responses: list[NDArray[np.float32]],
) -> Sweep:
    before, after = readings[0], readings[-1]
    doubts = dict.fromkeys(why for reading in readings for why in reading.doubts)
    return Sweep(
        step=set_point.step,
        direction=set_point.direction,
        level=set_point.level,
        oven_temperature_start=before.air,
        oven_temperature_end=after.air,
        start_time=began,
        drive=np.stack(drives),
        responses=np.stack(responses, axis=1),
        plate_temperature_start=before.plate,
        plate_temperature_end=after.plate,
        doubt="; ".join(doubts),
    )
