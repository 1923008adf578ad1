"""Calls that read codes, and that read and write waveforms with their time and unit."""

from datetime import UTC, datetime, timedelta
from importlib import import_module
from typing import Any

import numpy as np
from nidaqmx._stubs import nidaqmx_pb2 as pb

from drivers.ni.simulated.answering import answered
from drivers.ni.simulated.stream_calls import StreamCalls
from drivers.ni.simulated.task import Kind, Task

EPOCH = datetime(2000, 1, 1, tzinfo=UTC)
"""When virtual time begins."""
UNITS = {Kind.VOLTAGE_IN: "Volts", Kind.ACCELERATION_IN: "g", Kind.THERMOCOUPLE_IN: "Deg C"}


class WaveformCalls(StreamCalls):
    """The part of the service that moves samples in other shapes than numbers in a row."""

    @answered
    def ReadRaw(self, request: Any) -> Any:
        task = self.task_of(request)
        quanta = [getattr(channel.module, "quantum", None) for channel in task.channels]
        if None in quanta:
            self.lacks("ReadRaw of thermocouples")
        samples, status = self._read(task, request.num_samps_per_chan, request.timeout)
        volts = samples * np.array([channel.volts_per_unit for channel in task.channels])[:, None]
        codes = np.round(volts / np.array(quanta)[:, None])
        width = max(raw_bits(channel.module) for channel in task.channels)
        data = codes.T.astype(np.int32 if width == 32 else np.int16).tobytes()
        return pb.ReadRawResponse(
            status=status, read_array=data, samps_read=samples.shape[1], num_bytes_per_samp=width // 8
        )

    @answered
    def ReadAnalogWaveforms(self, request: Any) -> Any:
        from nidaqmx._grpc_interpreter import float64_analog_waveform_to_protobuf  # newer releases have it

        types = import_module("nitypes.waveform")  # which comes with them

        task = self.task_of(request)
        first = task.position
        samples, status = self._read(task, request.num_samps_per_chan, request.timeout)
        response = pb.ReadAnalogWaveformsResponse(status=status, samps_per_chan_read=samples.shape[1])
        for channel, values in zip(task.channels, samples, strict=True):
            waveform = types.AnalogWaveform.from_array_1d(values, np.float64)
            waveform.channel_name, waveform.units = channel.name, UNITS[channel.kind]
            if task.timing is not None:
                interval = timedelta(seconds=1.0 / task.timing.rate)
                waveform.timing = types.Timing.create_with_regular_interval(interval, self._when(task, first))
            response.waveforms.append(float64_analog_waveform_to_protobuf(waveform))
        return response

    def _when(self, task: Task, sample: int) -> datetime:
        began = task.began if task.began is not None else self.chassis.clock.now()
        return EPOCH + timedelta(seconds=began + sample / task.clocked().pace)

    @answered
    def WriteAnalogWaveforms(self, request: Any) -> Any:
        samples = np.array([waveform.y_data for waveform in request.waveforms], dtype=np.float64)
        self._write(self.task_of(request), samples, request.auto_start)
        return pb.WriteAnalogWaveformsResponse(samps_per_chan_written=samples.shape[1])


def raw_bits(module: Any) -> int:
    """Bits in which the driver hands a converter's code over."""
    return 16 if getattr(module, "bits", 32) <= 16 else 32
