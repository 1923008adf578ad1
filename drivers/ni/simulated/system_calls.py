"""Calls that ask what devices there are."""

from typing import Any

from nidaqmx._stubs import nidaqmx_pb2 as pb
from nidaqmx.error_codes import DAQmxErrors

from drivers.ni.modules import InputModule, OutputModule
from drivers.ni.simulated.answering import Answering, answered
from drivers.ni.simulated.chassis import PRODUCT
from drivers.ni.simulated.faults import DaqmxStatusError, status_name
from drivers.ni.simulated.surroundings import Module

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
