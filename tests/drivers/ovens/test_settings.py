import pytest
from pydantic import ValidationError

from drivers.clock import VirtualClock
from drivers.ovens.error import Fault, OvenError
from drivers.ovens.line import Timing
from drivers.ovens.oven import OvenLimits
from drivers.ovens.settings import OVENS, open_oven, oven_settings
from drivers.ovens.simulated.controller import MemoryTransport
from drivers.ovens.simulated.votsch import SimulatedVotsch
from tests.drivers.ovens.served import Disturbed, silenced

GIVEN = {"kind": "watlow-f4t", "port": "COM3", "minimum": -5, "maximum": 65, "max_rate": 2}


def test_limits_and_timing():
    settings = oven_settings({**GIVEN, "gap_after_write": 0.7, "retries": 4})
    assert settings.limits() == OvenLimits(-5.0, 65.0, 2.0)
    assert settings.timing() == Timing(1.0, 4, 0.02, 0.7, 60.0)


@pytest.mark.parametrize(
    ("change", "expires"),
    [
        ({}, False),
        ({"program": 40}, True),
        ({"program": 40, "rest_after": 0.0}, False),
        ({"kind": "espec-p300"}, True),
        ({"kind": "votsch-ascii2"}, False),
    ],
)
def test_whether_an_oven_ends_by_itself(change, expires):
    assert oven_settings({**GIVEN, **change}).expires is expires


def test_every_field_is_described():
    for kind in OVENS.all():
        for name, field in OVENS.find(kind).model_fields.items():
            assert field.description, name


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"minimum": 70}, "below the upper"),
        ({"maximum": 900}, "maximum"),
        ({"max_rate": 0}, "max_rate"),
        ({"timeout": 0}, "timeout"),
        ({"lost_after": 2, "timeout": 5}, "lost_after"),
        ({"kind": "votsch-ascii2", "address": 40}, "1 to 32"),
        ({"rest_after": 60.0}, r"0 \(never\) or 600 to 86400"),
        ({"kind": "votsch-ascii2", "program": 1}, "program"),
        ({"kind": "espec-p300", "program": 1}, "program"),
        ({"kind": "eurotherm-3500", "program": 1}, "none can be written"),
        ({"kind": "eurotherm-2400", "program": 21}, "1 to 20 allowed"),
        ({"program": 41}, "1 to 40 allowed"),
        ({"speed": 9600}, "speed"),
        ({"port": ""}, "port"),
        ({"port": "spy:///dev/ttyUSB0?file=notes.txt"}, "socket://HOST:PORT"),
        ({"port": "SPY://COM3?file=notes.txt"}, "socket://HOST:PORT"),
        ({"port": "socket://gateway:4001?logging=debug"}, "socket://HOST:PORT"),
        ({"port": "socket://:4001"}, "socket://HOST:PORT"),
        ({"port": "alt://COM3?class=PosixPollSerial"}, "socket://HOST:PORT"),
        ({"port": "/dev/tty\0USB0"}, "socket://HOST:PORT"),
        ({"port": "/dev/ttyUSB" + "9" * 5000}, "255 characters"),
    ],
)
def test_nonsense_is_refused(change, told):
    with pytest.raises(ValidationError, match=told):
        oven_settings({**GIVEN, **change})


@pytest.mark.parametrize(
    "port",
    ["COM3", "/dev/ttyUSB0", "socket://gateway.lab:4001", "socket://[fe80::1]:4001", "socket://10.0.0.7:23"],
)
def test_a_port_is_a_serial_port_or_a_socket_with_its_host(port):
    assert oven_settings({**GIVEN, "port": port}).port == port


def test_a_port_that_is_none():
    with pytest.raises(OvenError, match="cannot be opened") as caught:
        open_oven(oven_settings({**GIVEN, "port": "no-such-port"}))
    assert caught.value.fault is Fault.PORT
    assert "name" in caught.value.advice


def test_an_oven_that_does_not_answer_leaves_its_port_free(rig):
    clock = VirtualClock()
    far = Disturbed(SimulatedVotsch(rig.body))
    far.always = silenced
    transport = MemoryTransport(far, clock)
    with pytest.raises(OvenError) as caught:
        open_oven(oven_settings({**GIVEN, "kind": "votsch-ascii2"}), clock, transport)
    assert caught.value.fault is Fault.SILENT
    with pytest.raises(OvenError, match="closed"):
        transport.write(b"x")


def test_the_wrong_kind_is_told(rig):
    def use(kind):
        settings = oven_settings({**GIVEN, "kind": kind, "timeout": 0.5})
        open_oven(settings, rig.clock, MemoryTransport(rig.controller, rig.clock)).temperature()

    for kind in ("votsch-ascii2", "espec-p300", "watlow-f4t", "eurotherm-2400"):
        # the two Eurotherms share the registers that tell a temperature
        if kind.split("-")[0] != rig.settings.kind.split("-")[0]:
            with pytest.raises(OvenError) as caught:
                use(kind)
            assert caught.value.advice
            assert caught.value.fault in (Fault.SILENT, Fault.GARBLED, Fault.REFUSED)
