"""Calls that read and write samples, as numbers in a row, as codes, and as waveforms with their time and unit."""

from dataclasses import replace
from datetime import UTC, datetime, timedelta
from importlib import import_module
from typing import Any

import numpy as np
from nidaqmx._stubs import nidaqmx_pb2 as pb
from nidaqmx.error_codes import DAQmxErrors
from numpy.typing import NDArray

from drivers.ni.simulated.answering import Answering, answered
from drivers.ni.simulated.faults import DaqmxStatusError
from drivers.ni.simulated.task import Kind, Task, TaskState


class StreamCalls(Answering):
    """The part of the service that moves samples."""

    @answered
    def ReadAnalogF64(self, request: Any) -> Any:
        task = self.task_of(request)
        samples, status = self._read(task, request.num_samps_per_chan, request.timeout)
        by_channel = request.fill_mode_raw == pb.GROUP_BY_GROUP_BY_CHANNEL
        flat = (samples if by_channel else samples.T).ravel()
        response = pb.ReadAnalogF64Response(samps_per_chan_read=samples.shape[1], status=status)
        response.read_array.extend(flat.tolist())
        return response

    @answered
    def ReadAnalogScalarF64(self, request: Any) -> Any:
        samples, status = self._read(self.task_of(request), 1, request.timeout)
        if status:
            raise _not_yet(self.task_of(request))
        return pb.ReadAnalogScalarF64Response(value=samples[0, 0])

    def _read(self, task: Task, count: int, timeout: float) -> tuple[NDArray[np.float64], int]:
        """Return samples (C, n) and the status: fewer than asked for come with one that says so."""
        if task.broken is not None:
            raise task.broken
        if not task.is_input:
            raise DaqmxStatusError(
                DAQmxErrors.READ_NO_INPUT_CHANS_IN_TASK,
                f"Read failed, because there are no input channels in this task. Task Name: {task.name}",
            )
        if task.timing is None:
            self.chassis.reserve(task)
            try:
                readings = [self.acquisition.read_now(task) for _ in range(max(count, 1))]
            finally:
                self.chassis.release(task)
            return np.stack(readings, axis=1), 0
        if task.state is not TaskState.STARTED:
            self.chassis.start(task)
        self._stall()
        self._refuse_overwritten(task)
        wanted = self._wanted(task, count)
        self._await(task, task.position + wanted, timeout)
        if task.broken is not None:
            raise task.broken
        available = task.taken(self.chassis.clock.now()) - task.position
        got = min(wanted, available)
        if got == 0:
            return np.empty((len(task.channels), 0)), int(_not_yet(task).code) if wanted else 0
        samples = self.acquisition.samples(task, task.position, got)
        task.position += got
        return samples, 0 if got == wanted else int(_not_yet(task).code)

    def _stall(self) -> None:
        faults, chassis = self.chassis.faults, self.chassis
        if faults.stalled and chassis.clock.now() >= faults.stalled_at:
            chassis.faults = replace(faults, stalled=0.0)
            chassis.pass_time_to(chassis.clock.now() + faults.stalled)

    def _refuse_overwritten(self, task: Task) -> None:
        if task.taken(self.chassis.clock.now()) - task.position > task.buffer_size():
            raise DaqmxStatusError(
                DAQmxErrors.SAMPLES_NO_LONGER_AVAILABLE,
                "The application is not able to keep up with the hardware acquisition: the samples asked for "
                f"have been overwritten. Task Name: {task.name}",
            )

    def _wanted(self, task: Task, count: int) -> int:
        timing = task.clocked()
        if count < 0:  # all there is
            taken = timing.samples if timing.finite else task.taken(self.chassis.clock.now())
            return taken - task.position
        if timing.finite and task.position + count > timing.samples:
            raise DaqmxStatusError(
                DAQmxErrors.SAMPLES_WILL_NEVER_BE_AVAILABLE,
                "The application is attempting to read samples beyond the final sample acquired. "
                f"Task Name: {task.name}",
            )
        return count

    def _await(self, task: Task, total: int, timeout: float) -> None:
        """Let time pass until so many samples have been taken, or the patience is over."""
        now = self.chassis.clock.now()
        if task.began is None:
            # Whatever could trigger it is not going to happen while the only program waits here.
            self.chassis.pass_time_to(now + max(timeout, 0.0))
            return
        due = task.began + total / task.clocked().pace
        self.chassis.pass_time_to(due if timeout < 0.0 else min(due, now + timeout))

    @answered
    def WriteAnalogF64(self, request: Any) -> Any:
        task = self.task_of(request)
        samples = np.array(request.write_array, dtype=np.float64)
        shape = (len(task.channels), request.num_samps_per_chan)
        by_channel = request.data_layout_raw == pb.GROUP_BY_GROUP_BY_CHANNEL
        samples = samples.reshape(shape) if by_channel else samples.reshape(shape[::-1]).T
        self._write(task, samples, request.auto_start)
        return pb.WriteAnalogF64Response(samps_per_chan_written=samples.shape[1])

    @answered
    def WriteAnalogScalarF64(self, request: Any) -> Any:
        self._write(self.task_of(request), np.array([[request.value]]), request.auto_start)
        return pb.WriteAnalogScalarF64Response()

    def _write(self, task: Task, samples: NDArray[np.float64], auto_start: bool) -> None:
        self.chassis.verify(task)
        if task.is_input:
            raise DaqmxStatusError(
                DAQmxErrors.WRITE_NO_OUTPUT_CHANS_IN_TASK,
                f"Write cannot be performed, because there are no output channels. Task Name: {task.name}",
            )
        for channel, values in zip(task.channels, samples, strict=True):
            if np.max(np.abs(values), initial=0.0) > channel.reach * (1.0 + 1e-9):
                raise DaqmxStatusError(
                    DAQmxErrors.INVALID_AO_DATA_WRITE,
                    "Some or all of the samples to write to the device are outside the range configured: "
                    f"{channel.reach:g} V on {channel.terminal}. Task Name: {task.name}",
                )
        if task.timing is None:
            self.chassis.put(task, samples[:, -1])
            return
        if task.state is TaskState.STARTED:
            self._append(task, samples)
            return
        joined = samples if not task.written.size else np.concatenate([task.written, samples], axis=1)
        fits = joined.shape[1] <= task.timing.samples
        task.written = joined if fits else samples
        if auto_start:
            self.chassis.start(task)

    def _append(self, task: Task, samples: NDArray[np.float64]) -> None:
        timing = task.clocked()
        if task.regenerates or timing.finite or task.began is None:
            self.lacks("WriteAnalogF64 into a running buffer that is played again")
        now = self.chassis.clock.now()
        if task.began + task.written.shape[1] / timing.pace < now - 1e-9:
            raise DaqmxStatusError(
                DAQmxErrors.GEN_STOPPED_TO_PREVENT_REGEN_OF_OLD_SAMPLES,
                f"The generation has stopped to prevent the regeneration of old samples. Task Name: {task.name}",
            )
        room = task.written.shape[1] + samples.shape[1] - task.buffer_size()
        if task.taken(now) < room:  # as the driver does, it waits until there is room for them
            self.chassis.pass_time_to(task.began + room / timing.pace)
        task.written = np.concatenate([task.written, samples], axis=1)
        for channel, values in zip(task.channels, samples, strict=True):
            self.chassis.lines[channel.terminal].extend(values)

    @answered
    def SetBufferAttributeUInt32(self, request: Any) -> Any:
        task = self.task_of(request)
        values = {pb.BUFFER_ATTRIBUTE_INPUT_BUF_SIZE: True, pb.BUFFER_ATTRIBUTE_OUTPUT_BUF_SIZE: False}
        if self.one_of(values, pb.BufferUInt32Attribute, request):
            task.buffer = request.value
        return pb.SetBufferAttributeUInt32Response()

    @answered
    def CfgInputBuffer(self, request: Any) -> Any:
        self.task_of(request).buffer = request.num_samps_per_chan
        return pb.CfgInputBufferResponse()

    @answered
    def GetBufferAttributeUInt32(self, request: Any) -> Any:
        values = {pb.BUFFER_ATTRIBUTE_INPUT_BUF_SIZE: self.task_of(request).buffer_size()}
        return pb.GetBufferAttributeUInt32Response(value=self.one_of(values, pb.BufferUInt32Attribute, request))

    @answered
    def SetWriteAttributeInt32(self, request: Any) -> Any:
        task = self.task_of(request)
        self.one_of({pb.WRITE_ATTRIBUTE_REGEN_MODE: None}, pb.WriteInt32Attribute, request)
        task.regenerates = (request.value_raw or request.value) == pb.WRITE_INT32_REGENERATION_MODE1_ALLOW_REGEN
        return pb.SetWriteAttributeInt32Response()

    @answered
    def GetReadAttributeString(self, request: Any) -> Any:
        names = ", ".join(channel.name for channel in self.task_of(request).channels)
        values = {pb.READ_ATTRIBUTE_CHANNELS_TO_READ: names}
        return pb.GetReadAttributeStringResponse(value=self.one_of(values, pb.ReadStringAttribute, request))

    @answered
    def GetReadAttributeUInt32(self, request: Any) -> Any:
        task = self.task_of(request)
        values = {
            pb.READ_ATTRIBUTE_NUM_CHANS: len(task.channels),
            pb.READ_ATTRIBUTE_AVAIL_SAMP_PER_CHAN: task.taken(self.chassis.clock.now()) - task.position,
        }
        return pb.GetReadAttributeUInt32Response(value=self.one_of(values, pb.ReadUInt32Attribute, request))

    @answered
    def GetReadAttributeUInt64(self, request: Any) -> Any:
        task = self.task_of(request)
        values = {
            pb.READ_ATTRIBUTE_TOTAL_SAMP_PER_CHAN_ACQUIRED: task.taken(self.chassis.clock.now()),
            pb.READ_ATTRIBUTE_CURR_READ_POS: task.position,
        }
        return pb.GetReadAttributeUInt64Response(value=self.one_of(values, pb.ReadUInt64Attribute, request))

    @answered
    def GetReadAttributeBool(self, request: Any) -> Any:
        values = {pb.READ_ATTRIBUTE_READ_ALL_AVAIL_SAMP: False}
        return pb.GetReadAttributeBoolResponse(value=self.one_of(values, pb.ReadBoolAttribute, request))

    @answered
    def GetWriteAttributeUInt32(self, request: Any) -> Any:
        values = {pb.WRITE_ATTRIBUTE_NUM_CHANS: len(self.task_of(request).channels)}
        return pb.GetWriteAttributeUInt32Response(value=self.one_of(values, pb.WriteUInt32Attribute, request))


def _not_yet(task: Task) -> DaqmxStatusError:
    return DaqmxStatusError(
        DAQmxErrors.SAMPLES_NOT_YET_AVAILABLE,
        f"Some or all of the samples requested have not yet been acquired. Task Name: {task.name}",
    )


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
