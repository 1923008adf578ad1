"""Inputs through NI-DAQmx that are read without end: what a trigger in software looks for hits in.

Many cards (an NI 9234 among them) have no analog reference trigger, so that samples from before a hit cannot be
had from the hardware. The driver's circular buffer holds them anyway, on every card.
"""

from collections.abc import Callable
from contextlib import ExitStack
from typing import Any, Self, cast

import numpy as np
from nidaqmx.stream_readers import AnalogMultiChannelReader
from numpy.typing import NDArray

from drivers.ni.cards import Cards, go_on
from drivers.ni.connection import Connection
from drivers.ni.errors import Action, DaqError
from drivers.ni.task_setup import read_thermocouples, set_up_inputs, verified_inputs
from drivers.ni.wiring import InputWiring

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
