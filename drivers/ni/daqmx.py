"""The rig's cards through NI-DAQmx.

Inputs through NI-DAQmx that are read without end: what a trigger in software looks for hits in.

Many cards (an NI 9234 among them) have no analog reference trigger, so that samples from before a hit cannot be
had from the hardware. The driver's circular buffer holds them anyway, on every card.
"""

import logging
from collections.abc import Callable
from contextlib import ExitStack
from typing import Any, Self, cast

import numpy as np
from nidaqmx.constants import AcquisitionType, TaskMode
from nidaqmx.stream_readers import AnalogMultiChannelReader
from nidaqmx.stream_writers import AnalogSingleChannelWriter
from numpy.typing import ArrayLike, NDArray

from drivers.interruptions import held_back
from drivers.ni.cards import Action, Cards, DaqError, Record, go_on
from drivers.ni.connection import (
    Connection,
    read_thermocouples,
    set_up_inputs,
    set_up_output,
    set_up_output_channel,
    verified_inputs,
)
from drivers.ni.wiring import InputWiring, Wiring

DONE_MARGIN = 5.0
"""How much longer than the sweep a card may take to say it is done, s."""

SETTLING = 64
"""Zeros played to bring the output to rest: more than a delta-sigma output's filter remembers."""


log = logging.getLogger(__name__)


class DaqmxCards:
    """Output, inputs and thermocouples of a rig, each sweep synchronised by the input's own start trigger.

    The output is brought to 0 V when the cards are opened, after every sweep, and on every way out of one. It runs
    on the inputs' own timebase where the chassis can route that, which a rehearsal with zeros finds out.

    Parameters
    ----------
    wiring : Wiring
    channel : grpc.Channel, optional
        Leads to a server inside this process; `wiring.grpc` is then ignored.
    block : float
        How much is read at once, s. Short enough for Ctrl-C to take effect in the middle of a sweep.

    Raises
    ------
    DaqError
        If a terminal does not exist, is taken, or does not do what the wiring asks of it.
    """

    def __init__(self, wiring: Wiring, channel: Any = None, block: float = 0.5) -> None:
        if not 0.01 <= block <= 3600.0:
            raise ValueError(f"block of {block:g} s; 0.01 to 3600 allowed")
        self.wiring = wiring
        self._block = block
        self._connection = Connection(wiring.grpc, channel)
        self._sample_rate = wiring.sample_rate
        self._one_clock = True
        try:
            self.zero()  # first of all: an earlier program may have left a voltage
            self._sample_rate, self._full_scale = verified_inputs(self._connection, wiring)
            self.temperatures()
            self._connection.names_proven = True
            self._rehearse()
        except BaseException:
            self._connection.close()
            raise

    @property
    def sample_rate(self) -> float:
        """Rate of the inputs as read back, Hz; the output is asked for the same."""
        return self._sample_rate

    def sweep(self, drive: ArrayLike, check: Callable[[], None] = go_on) -> Record:
        """Play a drive and record it beside the responses.

        Parameters
        ----------
        drive : (M,) array_like, V
            At `sample_rate`. A silent tail long enough for the plate to come to rest is the caller's part.
        check : callable
            Called after every block that was read; raises to break the sweep off.

        Returns
        -------
        Record
            M samples from the moment the output starts.

        Raises
        ------
        DaqError
            Whatever goes wrong; the output has been brought to 0 V, or a note on the error says why not.
        """
        volts = np.ascontiguousarray(drive, dtype=np.float64)
        if volts.ndim != 1 or volts.size < 2 or not np.all(np.isfinite(volts)):
            raise ValueError(f"drive of shape {volts.shape}; (M,) finite voltages with M >= 2 allowed")
        peak = float(np.max(np.abs(volts)))
        if peak > self.wiring.output_range:
            raise ValueError(f"drive reaches {peak:g} V; output_range allows {self.wiring.output_range:g} V")
        with held_back() as let_through:

            def pausing() -> None:
                let_through()
                check()

            try:
                with self._connection.translated(f"the sweep of {volts.size / self._sample_rate:.3g} s"):
                    silence = np.zeros(round(self.wiring.settling * self._sample_rate))
                    recorded = self._play_and_record(np.concatenate([silence, volts]), pausing)[:, silence.size :]
            except BaseException as error:
                try:
                    self.zero()
                except Exception as unsafe:  # noqa: BLE001 (a lost card may say so in any way)
                    error.add_note(str(unsafe))
                raise
            self.zero()
        return Record(recorded[0], recorded[1:], self._sample_rate, self._full_scale)

    def temperatures(self) -> NDArray[np.float64]:
        """Read every thermocouple once, degrees Celsius."""
        return read_thermocouples(self._connection, self.wiring)

    def zero(self) -> None:
        """Bring the output to 0 V: by a short run of zeros or, if the card refuses that, by a single value.

        Raises
        ------
        DaqError
            If neither can be done: the output may hold any voltage.
        """
        try:
            self._zero_by(self._play_zeros)
        except DaqError:
            try:
                self._zero_by(lambda task: task.write(0.0, auto_start=True))
            except DaqError as error:
                if error.action is Action.LIST_EXISTING:  # there is no such output to worry about
                    raise
                step = f"turn the amplifier off: {self.wiring.output} may hold a voltage. Then {error.next_step}"
                raise DaqError(error.doing, error.said, error.code, error.action, step) from error

    def close(self) -> None:
        """Bring the output to 0 V and let go of the hardware."""
        try:
            with held_back():
                self.zero()
        finally:
            self._connection.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _play_and_record(self, volts: NDArray[np.float64], pausing: Callable[[], None]) -> NDArray[np.float64]:
        connection = self._connection
        with ExitStack() as tasks:
            inputs = tasks.enter_context(connection.task("inputs", self.wiring.inputs[0]))
            output = tasks.enter_context(connection.task("output", self.wiring.output))
            rate = set_up_inputs(inputs, self.wiring, volts.size)
            if not np.isclose(rate, self._sample_rate, rtol=1e-9):
                said = f"The inputs now run at {rate:g} Hz instead of {self._sample_rate:g} Hz."
                raise DaqError("the sweep", said, None, Action.STOP, "open the cards again")
            # Should this computer die in the middle, the hardware still comes to rest on these zeros.
            samples = np.concatenate([volts, np.zeros(2)])
            # Only a reserved task reports which of the chassis' timing engines it got, and with it its trigger.
            inputs.control(TaskMode.TASK_RESERVE)
            master = inputs if self._one_clock else None
            set_up_output(output, self.wiring, self._sample_rate, samples.size, master)
            output.triggers.start_trigger.cfg_dig_edge_start_trig(inputs.triggers.start_trigger.term)
            AnalogSingleChannelWriter(output.out_stream, auto_start=False).write_many_sample(samples)
            output.start()
            inputs.start()
            recorded = self._read(inputs, volts.size, pausing)
            output.wait_until_done(timeout=2.0 / rate + DONE_MARGIN)
            output.stop()
            inputs.stop()
        return recorded

    def _read(self, inputs: Any, samples: int, pausing: Callable[[], None]) -> NDArray[np.float64]:
        reader = AnalogMultiChannelReader(inputs.in_stream)
        recorded = np.empty((len(self.wiring.inputs), samples))
        step = min(samples, max(1, round(self._block * self._sample_rate)))
        for first in range(0, samples, step):
            count = min(step, samples - first)
            block = np.empty((len(recorded), count))
            read = reader.read_many_sample(block, count, timeout=count / self._sample_rate + DONE_MARGIN)
            if read != count:
                said = f"{read} samples came where {count} were asked for."
                raise DaqError("the sweep", said, None, Action.RETRY_DISCARD, "repeat the sweep")
            recorded[:, first : first + count] = block
            pausing()
        return recorded

    def _rehearse(self) -> None:
        """Play zeros as a sweep is played: on the inputs' timebase or, where that is refused, on the output's."""
        zeros = np.zeros(SETTLING)
        try:
            with self._connection.translated("a rehearsal on one timebase"):
                self._play_and_record(zeros, go_on)
        except DaqError as error:
            if error.action is not Action.STOP:
                raise
            log.debug("output and inputs keep clocks of their own: %s", error)
            self._one_clock = False
            with self._connection.translated("a rehearsal of a sweep"):
                self._play_and_record(zeros, go_on)

    def _play_zeros(self, task: Any) -> None:
        task.timing.cfg_samp_clk_timing(
            self._sample_rate, sample_mode=AcquisitionType.FINITE, samps_per_chan=SETTLING
        )
        AnalogSingleChannelWriter(task.out_stream, auto_start=False).write_many_sample(np.zeros(SETTLING))
        task.start()
        task.wait_until_done(timeout=SETTLING / self._sample_rate + DONE_MARGIN)
        task.stop()

    def _zero_by(self, write: Callable[[Any], object]) -> None:
        doing = f"bringing {self.wiring.output} to 0 V"
        with self._connection.translated(doing), self._connection.task("output", self.wiring.output) as task:
            set_up_output_channel(task, self.wiring)
            write(task)


BUFFER_SECONDS = 20.0
"""What the driver's buffer holds, s: a hit is judged and written in a fraction of a second, but a network disk may
take seconds."""
READ_MARGIN = 5.0
"""How much longer than the samples take a read may wait for them, s."""


class EndlessInputs:
    """Force and responses, read block by block; nothing is played.

    Parameters
    ----------
    wiring : InputWiring
    channel : grpc.Channel, optional
        Leads to a server inside this process; `wiring.grpc` is then ignored.

    Raises
    ------
    DaqError
        If a terminal does not exist, is taken, or does not do what the wiring asks of it.
    """

    def __init__(self, wiring: InputWiring, channel: Any = None) -> None:
        self.wiring = wiring
        self._connection = Connection(wiring.grpc, channel)
        self._tasks = ExitStack()
        self._reader: AnalogMultiChannelReader | None = None
        try:
            self._sample_rate, self._full_scale = verified_inputs(self._connection, wiring)
            self.temperatures()
            self._connection.names_proven = True
        except BaseException:
            self._connection.close()
            raise

    @property
    def sample_rate(self) -> float:
        """As read back, Hz."""
        return self._sample_rate

    @property
    def full_scale(self) -> float:
        """Voltage beyond which the inputs clip, V."""
        return self._full_scale

    def begin(self, check: Callable[[], None] = go_on) -> None:
        """Start to record; returns when the sensors' supply has settled.

        Parameters
        ----------
        check : callable
            Called meanwhile; raises to break it off.
        """
        self.stop()
        with self._connection.translated("starting to record"):
            task = self._tasks.enter_context(self._connection.task("inputs", self.wiring.inputs[0]))
            rate = set_up_inputs(task, self.wiring, round(BUFFER_SECONDS * self._sample_rate), endless=True)
            if not np.isclose(rate, self._sample_rate, rtol=1e-9):
                said = f"The inputs now run at {rate:g} Hz instead of {self._sample_rate:g} Hz."
                raise DaqError("starting to record", said, None, Action.STOP, "open the cards again")
            self._reader = AnalogMultiChannelReader(task.in_stream)
            task.start()
        left = round(self.wiring.settling * self._sample_rate)
        while left > 0:
            count = min(left, round(0.5 * self._sample_rate))
            self.read(count)
            left -= count
            check()

    def read(self, samples: int) -> NDArray[np.float64]:
        """Wait for the next samples, and return them, force first, (1 + K, samples), V.

        Raises
        ------
        DaqError
            If the cards are lost, or samples were overwritten before they were read.
        """
        if self._reader is None:
            raise ValueError("nothing is being recorded; call begin first")
        block = np.empty((len(self.wiring.inputs), samples))
        with self._connection.translated("recording"):
            read = self._reader.read_many_sample(block, samples, timeout=samples / self._sample_rate + READ_MARGIN)
        if read != samples:
            said = f"{read} samples came where {samples} were asked for."
            raise DaqError("recording", said, None, Action.RETRY_DISCARD, "hit again")
        return block

    def temperatures(self) -> NDArray[np.float64]:
        """Read every thermocouple once, (C,), degrees Celsius; empty where none is wired."""
        return read_thermocouples(self._connection, self.wiring)

    def stop(self) -> None:
        """End the recording."""
        self._reader = None
        with self._connection.translated("ending the recording"):
            self._tasks.close()

    def close(self) -> None:
        """Let go of the hardware."""
        try:
            self.stop()
        finally:
            self._connection.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def as_cards(inputs: EndlessInputs) -> Cards:
    """Return inputs as what a `Session` opens and closes: it reads temperatures, and never asks for a sweep."""
    return cast(Cards, inputs)
