"""Calls that make channels and set them up.

Calls that ask what devices there are.
"""

from typing import Any

import numpy as np
from nidaqmx._stubs import nidaqmx_pb2 as pb
from nidaqmx.error_codes import DAQmxErrors
from nidaqmx.utils import unflatten_channel_string

from drivers.ni.modules import InputModule, OutputModule, ThermocoupleModule
from drivers.ni.simulated.answering import Answering, answered
from drivers.ni.simulated.chassis import PRODUCT
from drivers.ni.simulated.faults import DaqmxStatusError, status_name
from drivers.ni.simulated.stream_calls import raw_bits
from drivers.ni.simulated.surroundings import Module
from drivers.ni.simulated.task import Kind, Task, TaskChannel

_MODULE_FOR = {
    Kind.VOLTAGE_IN: InputModule,
    Kind.ACCELERATION_IN: InputModule,
    Kind.THERMOCOUPLE_IN: ThermocoupleModule,
    Kind.VOLTAGE_OUT: OutputModule,
}


class ChannelCalls(Answering):
    """The part of the service that has to do with channels."""

    @answered
    def CreateAIVoltageChan(self, request: Any) -> Any:
        self._refuse_terminal_configuration(request)
        self._add(request, Kind.VOLTAGE_IN)
        return pb.CreateAIVoltageChanResponse()

    @answered
    def CreateAIVoltageChanWithExcit(self, request: Any) -> Any:
        # The module feeds sensors a current, never a voltage.
        internal = pb.EXCITATION_SOURCE_INTERNAL
        if (
            request.voltage_excit_source_raw or request.voltage_excit_source
        ) == internal and request.voltage_excit_val:
            raise _unsupported("AI.Excit.Val", "no voltage excitation on this module")
        self._refuse_terminal_configuration(request)
        self._add(request, Kind.VOLTAGE_IN)
        return pb.CreateAIVoltageChanWithExcitResponse()

    @answered
    def CreateAIAccelChan(self, request: Any) -> Any:
        self._refuse_terminal_configuration(request)
        per_g = pb.ACCEL_SENSITIVITY_UNITS1_M_VOLTS_PER_G
        if (request.sensitivity_units_raw or request.sensitivity_units) != per_g:
            self.lacks("CreateAIAccelChan sensitivity in V/g")
        if (request.units_raw or request.units) != pb.ACCEL_UNITS2_ACCEL_UNIT_G:
            self.lacks("CreateAIAccelChan units other than g")
        volts_per_g = request.sensitivity / 1000.0
        for channel in self._add(request, Kind.ACCELERATION_IN, volts_per_g):
            internal = pb.EXCITATION_SOURCE_INTERNAL
            # The sensor's supply sits on the signal as a voltage of its own: the module then couples AC.
            channel.feeds = (request.current_excit_source_raw or request.current_excit_source) == internal
            channel.ac_coupled = channel.feeds
            if channel.feeds and not getattr(channel.module, "iepe", False):
                task = self.task_of(request)
                task.channels.remove(channel)
                raise _unsupported("AI.Excit.Src", f"{channel.module.name} feeds no sensor")
        return pb.CreateAIAccelChanResponse()

    @answered
    def CreateAIThrmcplChan(self, request: Any) -> Any:
        if (request.units_raw or request.units) != pb.TEMPERATURE_UNITS_DEG_C:
            self.lacks("CreateAIThrmcplChan units other than degrees Celsius")
        self._add(request, Kind.THERMOCOUPLE_IN)
        return pb.CreateAIThrmcplChanResponse()

    @answered
    def CreateAOVoltageChan(self, request: Any) -> Any:
        self._add(request, Kind.VOLTAGE_OUT)
        return pb.CreateAOVoltageChanResponse()

    def _add(self, request: Any, kind: Kind, volts_per_unit: float = 1.0) -> list[TaskChannel]:
        task = self.task_of(request)
        terminals = _listed(request.physical_channel)
        given = request.name_to_assign_to_channel
        reach = max(abs(request.min_val), abs(request.max_val))
        added = []
        for number, terminal in enumerate(terminals):
            module = self._module_at(terminal, kind)
            full_scale = getattr(module, "full_scale", float("inf"))
            if reach * volts_per_unit > full_scale * (1.0 + 1e-9):
                raise _unsupported(
                    "Max", f"{reach:g} is beyond the {full_scale / volts_per_unit:g} of {module.name}"
                )
            name = given if len(terminals) == 1 else f"{given}{number}"
            added.append(
                TaskChannel(name if given else terminal, terminal, module, kind, reach, False, volts_per_unit)
            )
        self._check_directions(task, added)
        task.channels.extend(added)
        task.written = np.empty(0)  # what lay in the buffer had not as many channels
        return added

    def _module_at(self, terminal: str, kind: Kind) -> Module:
        device = terminal.split("/")[0]
        if device not in self.chassis.devices():
            raise DaqmxStatusError(
                DAQmxErrors.INVALID_DEVICE_ID, f"Device identifier is invalid. Device Specified: {device}"
            )
        module = self.chassis.surroundings.terminals().get(terminal)
        if module is None:
            raise DaqmxStatusError(
                DAQmxErrors.PHYSICAL_CHAN_DOES_NOT_EXIST,
                f"Physical channel specified does not exist on this device. Physical Channel Name: {terminal}",
            )
        if not isinstance(module, _MODULE_FOR[kind]):
            raise _unsupported("AI.MeasType", f"{module.name} has no {kind.value}")
        return module

    def _check_directions(self, task: Task, added: list[TaskChannel]) -> None:
        outputs = {channel.kind is Kind.VOLTAGE_OUT for channel in task.channels + added}
        if len(outputs) > 1:
            raise DaqmxStatusError(
                DAQmxErrors.INVALID_CHANNEL, f"Task cannot hold inputs and outputs. Task Name: {task.name}"
            )

    def _refuse_terminal_configuration(self, request: Any) -> None:
        allowed = (
            pb.INPUT_TERM_CFG_WITH_DEFAULT_CFG_DEFAULT,
            pb.INPUT_TERM_CFG_WITH_DEFAULT_PSEUDO_DIFF,
        )
        if (request.terminal_config_raw or request.terminal_config) not in allowed:
            raise _unsupported("AI.TermCfg", "pseudodifferential is the only one possible")

    def _named(self, request: Any) -> list[TaskChannel]:
        task = self.task_of(request)
        names = _listed(request.channel) or [channel.name for channel in task.channels]
        found = [channel for channel in task.channels if channel.name in names]
        if len(found) != len(names):
            raise DaqmxStatusError(
                DAQmxErrors.INVALID_CHANNEL, f"Channel {request.channel} is not in task {task.name}."
            )
        return found

    @answered
    def GetChanAttributeInt32(self, request: Any) -> Any:
        channel = self._named(request)[0]
        is_output = channel.kind is Kind.VOLTAGE_OUT
        measured = {
            Kind.VOLTAGE_IN: pb.CHANNEL_INT32_AI_MEASUREMENT_TYPE_VOLTAGE,
            Kind.ACCELERATION_IN: pb.CHANNEL_INT32_AI_MEASUREMENT_TYPE_ACCELEROMETER,
            Kind.THERMOCOUPLE_IN: pb.CHANNEL_INT32_AI_MEASUREMENT_TYPE_TEMP_TC,
            Kind.VOLTAGE_OUT: pb.CHANNEL_INT32_AO_OUTPUT_CHANNEL_TYPE_VOLTAGE,
        }[channel.kind]
        coupling = pb.CHANNEL_INT32_COUPLING1_AC if channel.ac_coupled else pb.CHANNEL_INT32_COUPLING1_DC
        values = {
            pb.CHANNEL_ATTRIBUTE_CHAN_TYPE: (
                pb.CHANNEL_INT32_CHANNEL_TYPE_AO if is_output else pb.CHANNEL_INT32_CHANNEL_TYPE_AI
            ),
            pb.CHANNEL_ATTRIBUTE_AI_MEAS_TYPE: measured,
            pb.CHANNEL_ATTRIBUTE_AO_OUTPUT_TYPE: measured,
            pb.CHANNEL_ATTRIBUTE_AI_COUPLING: coupling,
        }
        return pb.GetChanAttributeInt32Response(value_raw=self.one_of(values, pb.ChannelInt32Attribute, request))

    @answered
    def SetChanAttributeInt32(self, request: Any) -> Any:
        # Asking what it is now refuses a property this server does not have.
        self.one_of({pb.CHANNEL_ATTRIBUTE_AI_COUPLING: None}, pb.ChannelInt32Attribute, request)
        wanted = request.value_raw or request.value
        for channel in self._named(request):
            allowed = [pb.CHANNEL_INT32_COUPLING1_DC]
            if getattr(channel.module, "coupling_corner", 0.0):
                allowed.append(pb.CHANNEL_INT32_COUPLING1_AC)
            if wanted not in allowed:
                raise _unsupported("AI.Coupling", "AC or DC" if len(allowed) > 1 else "DC only")
            channel.ac_coupled = wanted == pb.CHANNEL_INT32_COUPLING1_AC
        return pb.SetChanAttributeInt32Response()

    @answered
    def GetChanAttributeDouble(self, request: Any) -> Any:
        channel = self._named(request)[0]
        # The module has one range and takes it whatever was asked for.
        reach = getattr(channel.module, "full_scale", channel.reach) / channel.volts_per_unit
        values = {
            pb.CHANNEL_ATTRIBUTE_AI_MAX: reach,
            pb.CHANNEL_ATTRIBUTE_AI_MIN: -reach,
            pb.CHANNEL_ATTRIBUTE_AO_MAX: reach,
            pb.CHANNEL_ATTRIBUTE_AO_MIN: -reach,
            pb.CHANNEL_ATTRIBUTE_AI_RNG_HIGH: reach,
            pb.CHANNEL_ATTRIBUTE_AI_RNG_LOW: -reach,
        }
        return pb.GetChanAttributeDoubleResponse(value=self.one_of(values, pb.ChannelDoubleAttribute, request))

    @answered
    def SetChanAttributeDouble(self, request: Any) -> Any:
        limits = (pb.CHANNEL_ATTRIBUTE_AI_MAX, pb.CHANNEL_ATTRIBUTE_AI_MIN)
        outputs = (pb.CHANNEL_ATTRIBUTE_AO_MAX, pb.CHANNEL_ATTRIBUTE_AO_MIN)
        self.one_of(dict.fromkeys(limits + outputs), pb.ChannelDoubleAttribute, request)
        for channel in self._named(request):
            full_scale = getattr(channel.module, "full_scale", float("inf")) / channel.volts_per_unit
            if abs(request.value) > full_scale * (1.0 + 1e-9):
                raise _unsupported(
                    "Max", f"{request.value:g} is beyond the {full_scale:g} of {channel.module.name}"
                )
            channel.reach = abs(request.value)
        return pb.SetChanAttributeDoubleResponse()

    @answered
    def GetChanAttributeUInt32(self, request: Any) -> Any:
        values = {pb.CHANNEL_ATTRIBUTE_AI_RAW_SAMP_SIZE: raw_bits(self._named(request)[0].module)}
        return pb.GetChanAttributeUInt32Response(value=self.one_of(values, pb.ChannelUInt32Attribute, request))

    @answered
    def GetChanAttributeString(self, request: Any) -> Any:
        values = {pb.CHANNEL_ATTRIBUTE_PHYSICAL_CHAN_NAME: self._named(request)[0].terminal}
        return pb.GetChanAttributeStringResponse(value=self.one_of(values, pb.ChannelStringAttribute, request))


def _listed(channels: str) -> list[str]:
    """Return names in a list of channels, each of which may begin with a slash."""
    return [name.removeprefix("/") for name in unflatten_channel_string(channels)]


def _unsupported(what: str, why: str) -> DaqmxStatusError:
    return DaqmxStatusError(
        DAQmxErrors.INVALID_ATTRIBUTE_VALUE,
        f"Requested value is not a supported value for this property. Property: {what}: {why}",
    )


VERSION = (24, 0, 0)
"""Of the simulated driver: the last version whose documented properties give all that a client needs."""


class SystemCalls(Answering):
    """The part of the service that has to do with the system and its devices."""

    @answered
    def GetSystemInfoAttributeUInt32(self, request: Any) -> Any:
        names = (
            pb.SYSTEM_ATTRIBUTE_NIDAQ_MAJOR_VERSION,
            pb.SYSTEM_ATTRIBUTE_NIDAQ_MINOR_VERSION,
            pb.SYSTEM_ATTRIBUTE_NIDAQ_UPDATE_VERSION,
        )
        values = dict(zip(names, VERSION, strict=True))
        return pb.GetSystemInfoAttributeUInt32Response(
            value=self.one_of(values, pb.SystemUInt32Attribute, request)
        )

    @answered
    def GetSystemInfoAttributeString(self, request: Any) -> Any:
        devices = self.chassis.devices()
        names = [self.chassis.surroundings.chassis, *devices] if devices else []
        values = {
            pb.SYSTEM_ATTRIBUTE_DEV_NAMES: ", ".join(names),
            pb.SYSTEM_ATTRIBUTE_TASKS: "",
            pb.SYSTEM_ATTRIBUTE_GLOBAL_CHANS: "",
            pb.SYSTEM_ATTRIBUTE_SCALES: "",
        }
        return pb.GetSystemInfoAttributeStringResponse(
            value=self.one_of(values, pb.SystemStringAttribute, request)
        )

    def _device(self, request: Any) -> Module | None:
        """Return the module a request names; None is the chassis itself."""
        return self._device_named(request.device_name)

    def _device_named(self, name: str) -> Module | None:
        devices = self.chassis.devices()
        if devices and name == self.chassis.surroundings.chassis:
            return None
        if name not in devices:
            raise DaqmxStatusError(
                DAQmxErrors.INVALID_DEVICE_ID, f"Device identifier is invalid. Device Specified: {name}"
            )
        return devices[name]

    @answered
    def GetDeviceAttributeString(self, request: Any) -> Any:
        module = self._device(request)
        kind = "ao" if isinstance(module, OutputModule) else "ai"
        channels = [f"{request.device_name}/{kind}{n}" for n in range(module.channels)] if module else []
        chassis = self.chassis.surroundings.chassis
        values = {
            pb.DEVICE_ATTRIBUTE_PRODUCT_TYPE: module.name.replace("NI-", "NI ") if module else PRODUCT,
            pb.DEVICE_ATTRIBUTE_AI_PHYSICAL_CHANS: ", ".join(channels) if kind == "ai" else "",
            pb.DEVICE_ATTRIBUTE_AO_PHYSICAL_CHANS: ", ".join(channels) if kind == "ao" else "",
            pb.DEVICE_ATTRIBUTE_CHASSIS_MODULE_DEV_NAMES: "" if module else ", ".join(self.chassis.devices()),
            pb.DEVICE_ATTRIBUTE_COMPACT_DAQ_CHASSIS_DEV_NAME: chassis if module else "",
        }
        return pb.GetDeviceAttributeStringResponse(value=self.one_of(values, pb.DeviceStringAttribute, request))

    @answered
    def GetDeviceAttributeUInt32(self, request: Any) -> Any:
        self._device(request)
        slots = {
            f"{self.chassis.surroundings.chassis}Mod{slot}": slot for slot in self.chassis.surroundings.modules
        }
        values = {
            pb.DEVICE_ATTRIBUTE_SERIAL_NUM: 0,
            pb.DEVICE_ATTRIBUTE_COMPACT_DAQ_SLOT_NUM: slots.get(request.device_name, 0),
        }
        return pb.GetDeviceAttributeUInt32Response(value=self.one_of(values, pb.DeviceUInt32Attribute, request))

    @answered
    def GetDeviceAttributeDoubleArray(self, request: Any) -> Any:
        module = self._device_named(request.device_name.partition("/")[0])  # NI's playrec.py names a channel
        inputs = [module.full_scale] if isinstance(module, InputModule) else []
        outputs = [module.full_scale] if isinstance(module, OutputModule) else []
        ranges = {
            pb.DEVICE_ATTRIBUTE_AI_VOLTAGE_RNGS: inputs,
            pb.DEVICE_ATTRIBUTE_AO_VOLTAGE_RNGS: outputs,
        }
        found = self.one_of(ranges, pb.DeviceDoubleArrayAttribute, request)
        return pb.GetDeviceAttributeDoubleArrayResponse(value=[end for top in found for end in (-top, top)])

    @answered
    def GetDeviceAttributeBool(self, request: Any) -> Any:
        self._device(request)
        values = {pb.DEVICE_ATTRIBUTE_IS_SIMULATED: True}
        return pb.GetDeviceAttributeBoolResponse(value=self.one_of(values, pb.DeviceBoolAttribute, request))

    @answered
    def GetDeviceAttributeInt32(self, request: Any) -> Any:
        is_module = self._device(request) is not None
        category = (
            pb.DEVICE_INT32_PRODUCT_CATEGORY_C_SERIES_MODULE
            if is_module
            else pb.DEVICE_INT32_PRODUCT_CATEGORY_COMPACT_DAQ_CHASSIS
        )
        values = {pb.DEVICE_ATTRIBUTE_PRODUCT_CATEGORY: category}
        return pb.GetDeviceAttributeInt32Response(value_raw=self.one_of(values, pb.DeviceInt32Attribute, request))

    @answered
    def ResetDevice(self, request: Any) -> Any:
        self._device(request)
        name = request.device_name
        for task in self.chassis.tasks.values():
            if name in (*task.devices(), self.chassis.surroundings.chassis):
                self.chassis.release(task)
        for terminal, line in self.chassis.lines.items():
            if terminal.startswith(f"{name}/") or name == self.chassis.surroundings.chassis:
                line.hold(0.0, self.chassis.clock.now())
        return pb.ResetDeviceResponse()

    @answered
    def SelfTestDevice(self, request: Any) -> Any:
        self._device(request)
        return pb.SelfTestDeviceResponse()

    @answered
    def GetErrorString(self, request: Any) -> Any:
        return pb.GetErrorStringResponse(error_string=f"{status_name(request.error_code)}.")
