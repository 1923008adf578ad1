"""Every call of NI's service that is not simulated, refused by its name.

A call without a method ends in the advice to upgrade the server, which does not say what is missing.
"""

from collections.abc import Callable
from typing import Any

from nidaqmx._stubs.nidaqmx_pb2_grpc import NiDAQmxServicer

from drivers.ni.simulated.answering import Answering, NotSimulatedError, refuse_lacking


class Refusals(Answering):
    """The part of the service that is not there; whatever is takes its place."""


def _refusing(call: str) -> Callable[[Answering, Any, Any], Any]:
    def refused(self: Answering, request: Any, context: Any) -> Any:
        what = f"{call} {_property_of(request)}".strip()
        self.lacking.add(what)
        return refuse_lacking(context, NotSimulatedError(what))

    return refused


def _property_of(request: Any) -> str:
    """Name of the property that a request is about, if it is about one."""
    field = request.DESCRIPTOR.fields_by_name.get("attribute")
    if field is None:
        return ""
    number = int(request.attribute_raw or request.attribute)
    named = field.enum_type.values_by_number.get(number)
    return named.name if named else str(number)


VENDORS_CALLS = tuple(name for name in vars(NiDAQmxServicer) if name[0].isupper())
for _name in VENDORS_CALLS:
    setattr(Refusals, _name, _refusing(_name))
