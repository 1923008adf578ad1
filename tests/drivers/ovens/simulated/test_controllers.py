"""What is peculiar to one maker's controller, and how its driver tells it."""

import pytest

from drivers.ovens.error import Fault, OvenError
from tests.drivers.ovens.served import silenced, untouched


def fault_of(action, *arguments):
    with pytest.raises(OvenError) as caught:
        action(*arguments)
    return caught.value


def test_eurotherm_memory_is_spared(rig_of):
    rig = rig_of("eurotherm-2400")
    rig.oven.ramp_to(40.0, 0.4)
    rig.wait(3600.0)
    assert rig.controller.writes == [(35, pytest.approx(0.4)), (2, 40.0), (273, 0)]
    rig.oven.ramp_to(40.0, 0.4)
    assert len(rig.controller.writes) == 3


def test_eurotherm_memory_is_spared_by_renewals(rig_of):
    """A renewal is a reset and a start: of what is kept, only set-point 1 is written, twice."""
    rig = rig_of("eurotherm-2400", program=1)
    rig.oven.ramp_to(30.0, 2.0)
    before = len(rig.controller.writes)
    rig.wait(300.0 + 1.5 * 1800.0)
    assert [register for register, _ in rig.controller.writes[before:]] == 2 * [24, 23, 23, 24]
    assert rig.oven.temperature() == pytest.approx(30.0, abs=0.2)


def test_f4t_memory_is_spared_by_renewals(rig_of):
    rig = rig_of("watlow-f4t", program=1)
    rig.oven.ramp_to(30.0, 2.0)
    before = len(rig.controller.writes)
    rig.wait(300.0 + 1.5 * 1800.0)
    renewed = [register for register, _ in rig.controller.writes[before:]]
    assert renewed == [16566, 2782, 16560, 16562, 2782, 16566, 2782, 16562, 2782]  # step 2 of the profile, once
    assert rig.oven.temperature() == pytest.approx(30.0, abs=0.2)


@pytest.mark.parametrize("kind", ["eurotherm-2400", "watlow-f4t"])
def test_a_program_that_nobody_renews_ends_with_the_oven_at_rest(rig_of, kind):
    rig = rig_of(kind, program=1)
    rig.oven.ramp_to(60.0, 0.5)
    rig.clock.sleep(80.0 * 60.0 + 1700.0)
    assert rig.body.regulating
    assert rig.body.working == pytest.approx(60.0, abs=0.1)
    rig.clock.sleep(200.0)
    assert not rig.body.regulating
    assert rig.oven.hold() == pytest.approx(rig.body.air, abs=0.3)  # and back to work


def test_eurotherm_3500_starts_with_its_rate_disabled(rig_of):
    rig = rig_of("eurotherm-3500")
    rig.oven.ramp_to(40.0, 0.5)
    rig.wait(600.0)
    assert rig.body.working == pytest.approx(25.0, abs=0.2)
    assert (78, 0) in rig.controller.writes


@pytest.mark.parametrize(
    ("kind", "fault", "advice"),
    [
        ("eurotherm-2400", Fault.NOT_TAKEN, "limits"),  # clamps without a word
        ("votsch-ascii2", Fault.REFUSED, "limits"),
        ("espec-p300", Fault.REFUSED, "limits"),
        ("watlow-f4t", Fault.REFUSED, "limits"),
    ],
)
def test_own_limits_are_told(rig_of, kind, fault, advice):
    rig = rig_of(kind, minimum=-80.0, maximum=70.0)
    if kind == "eurotherm-2400":
        rig.controller._low = -30.0
    error = fault_of(rig.oven.ramp_to, -79.0, 1.0)
    assert error.fault is fault
    assert advice in error.advice
    assert not rig.body.regulating


@pytest.mark.parametrize("decimals", [0, 1, 2])
def test_eurotherm_with_any_decimals(rig_of, decimals):
    rig = rig_of("eurotherm-2400", decimals=decimals)
    assert rig.oven.ramp_to(25.0, 0.4).rate == pytest.approx(0.4)
    rig.wait(1500.0)
    assert rig.oven.temperature() == pytest.approx(25.0, abs=0.2)


@pytest.mark.parametrize("kind", ["eurotherm-2400", "watlow-f4t"])
def test_a_broken_sensor_is_an_alarm(rig_of, kind):
    rig = rig_of(kind)
    rig.controller.sensor_broken = True
    assert fault_of(rig.oven.temperature).fault is Fault.ALARM


def test_eurotherm_3500_alarms(rig_of):
    rig = rig_of("eurotherm-3500")
    rig.controller.alarms = 0x0004
    assert fault_of(rig.oven.temperature).code == "0x0004"


def test_espec_alarms_and_protection(rig_of):
    rig = rig_of("espec-p300")
    rig.controller.alarms = (7, 10)
    assert fault_of(rig.oven.temperature).code == "2,7,10"
    rig.controller.alarms = ()
    rig.controller.protected = True
    error = fault_of(rig.oven.ramp_to, 30.0, 1.0)
    assert (error.fault, error.code) == (Fault.REFUSED, "NA:PROTECT ON")
    assert "protection" in error.advice


def test_espec_stops_when_nobody_asks(rig_of):
    rig = rig_of("espec-p300")
    rig.oven.ramp_to(60.0, 1.0)
    rig.wait(300.0)  # asking
    assert rig.body.regulating
    rig.clock.sleep(rig.oven.poll_within - 1.0)
    rig.oven.temperature()
    rig.clock.sleep(rig.oven.poll_within + 1.0)
    error = fault_of(rig.oven.temperature)
    assert (error.fault, error.code) == (Fault.ALARM, "STANDBY")
    assert not rig.body.regulating
    rig.oven.ramp_to(60.0, 1.0)
    assert rig.body.regulating


def test_votsch_at_another_address(rig_of):
    rig = rig_of("votsch-ascii2", address=7)
    assert rig.oven.ramp_to(30.0, 1.0).target == 30.0
    assert rig.controller.receive(b"$01I\r") == []


@pytest.mark.parametrize("kind", ["eurotherm-2400", "watlow-f4t"])
def test_modbus_at_another_address(rig_of, kind):
    rig = rig_of(kind, address=17)
    assert rig.oven.ramp_to(30.0, 1.0).target == 30.0
    assert rig.controller.receive(bytes.fromhex("010300010001d5ca")) == []


@pytest.mark.parametrize("kind", ["eurotherm-2400", "watlow-f4t"])
def test_a_renewal_that_was_broken_off_is_made_good(rig_of, kind):
    rig = rig_of(kind, program=1)
    rig.oven.ramp_to(30.0, 2.0)
    rig.wait(1190.0)
    for number in range(2, 9):
        rig.clock.sleep(15.0 * 60.0)
        rig.disturbed.disturb(*[untouched] * number, *[silenced] * 3)
        with pytest.raises(OvenError):
            rig.oven.renew()
        rig.oven.renew()
        rig.wait(10.0)
        assert rig.body.target == pytest.approx(30.0)
        assert rig.body.stop_at == pytest.approx(rig.clock.now() + 1790.0, abs=3.0)
