"""Ovens that are declared altogether: frames and words by hand, ramps in steps, what is refused when read."""

import logging

import pytest
from pydantic import ValidationError

from drivers.clock import VirtualClock
from drivers.ovens.error import Fault, OvenError
from drivers.ovens.line import Line, Timing
from drivers.ovens.modbus import ModbusUnit
from drivers.ovens.registers import Register, TemperatureRegister
from drivers.ovens.settings import oven_settings
from drivers.ovens.simulated.controller import MemoryTransport
from tests.drivers.ovens.served import instead, late, silenced

GIVEN = {"port": "none", "minimum": -5.0, "maximum": 65.0, "max_rate": 2.0, "timeout": 0.5}
REGISTERS = {
    **GIVEN,
    "kind": "modbus-map",
    "temperature": {"at": 1, "scale": 0.1},
    "set_point": {"at": 2, "scale": 0.1},
    "run": {"at": 3},
}
WORDS = {
    **GIVEN,
    "kind": "scpi",
    "temperature": {"query": "TEMP?"},
    "set_point": {"query": "SET?", "command": "SET {value}"},
    "run": {"on": "RUN", "off": "STOP", "query": "STATE?"},
}
STEPPED = {"modbus-map": REGISTERS, "scpi": WORDS}


def plain(declared, **changes):
    """Return what turns the richer declaration of the other tests into this one."""
    changed = {"rate": None, "working_set_point": None, "status": None, **declared, **changes}
    return {key: value for key, value in changed.items() if key != "kind"}


@pytest.fixture(params=STEPPED)
def stepped(request, rig_of):
    """Return an oven whose controller has no ramp, open and at rest at 20 °C."""
    return rig_of(request.param, **plain(STEPPED[request.param]))


@pytest.fixture
def unit(scripted):
    return lambda pairs, **options: ModbusUnit(scripted(pairs), 17, **options)


def test_a_negative_number_of_16_bits(unit):
    # the specification's own unit 17; -12.3 is 0xff85
    pairs = [(bytes.fromhex("11 04 006b 0001 4286"), bytes.fromhex("11 04 02 ff85 f8a0"))]
    declared = TemperatureRegister(at=0x6B, table="input", scale=0.1)
    assert Register("temperature", unit(pairs), declared, "high word first").read() == pytest.approx(-12.3)


def test_a_float_in_an_envelope_low_word_first(unit):
    # 23.5 is 0x41bc0000; question 1, unit 17, function 3, registers 256 and 257
    pairs = [(bytes.fromhex("0001 0000 0006 11 03 0100 0002"), bytes.fromhex("0001 0000 0007 11 03 04 0000 41bc"))]
    declared = TemperatureRegister(at=256, type="float32")
    register = Register("temperature", unit(pairs, framing="tcp"), declared, "low word first")
    assert register.read() == 23.5


def test_an_answer_to_another_question_is_none(unit):
    pairs = [
        (bytes.fromhex("0001 0000 0006 11 03 0100 0001"), bytes.fromhex("0009 0000 0005 11 03 02 00eb")),
    ]
    declared = TemperatureRegister(at=256)
    with pytest.raises(OvenError, match="no answer to question 1") as caught:
        Register("temperature", unit(pairs, framing="tcp"), declared, "high word first").read()
    assert caught.value.fault is Fault.GARBLED


def test_a_set_point_is_rounded_to_its_counts_and_read_back(unit):
    # 41.26 °C are 106.27 °F: 1063 counts of 0.1, 0x0427
    asked = bytes.fromhex("11 03 0002 0001 275a")
    wrote = bytes.fromhex("11 06 0002 0427 6840")
    pairs = [
        (asked, bytes.fromhex("11 03 02 0000 7987")),
        (wrote, wrote),
        (asked, bytes.fromhex("11 03 02 0427 3b5d")),
    ]
    declared = TemperatureRegister(at=2, scale=0.1, unit="degF")
    taken = Register("set_point", unit(pairs), declared, "high word first").put(41.26)
    assert taken == pytest.approx((106.3 - 32.0) / 1.8, abs=1e-4)


def test_words_by_hand(scripted, monkeypatch):
    settings = oven_settings({**WORDS, "terminator": "\r\n", "set_point": {**WORDS["set_point"], "unit": "K"}})
    line = scripted(
        [
            (b"TEMP?\r\n", b"+2.0500E+01\r\n"),
            (b"SET?\r\n", b"293.15\r\n"),
            (b"STATE?\r\n", b"0\r\n"),
        ]
    )
    monkeypatch.setattr(type(settings), "line", lambda self, clock, transport: line)
    assert settings.open(VirtualClock()).temperature() == 20.5


@pytest.mark.parametrize(
    ("answer", "words", "field", "value"),
    [
        ("{value}", "23.5", 1, 23.5),
        ("{value}", " -2.350E+01 ", 1, -23.5),
        ("T={value} C", "T=23.5 C", 1, 23.5),
        ("{value}", "1,23.5,x", 2, 23.5),
        ("{value}", "23,5", 1, 23.0),
        ("{value}", "", 1, None),
        ("{value}", "23.5C", 1, None),
        ("{value}", "nan", 1, None),
        ("{value}", "2350", 1, None),
        ("{value}", "1e9999", 1, None),
        ("{value}", "0x10", 1, None),
        ("{value}", "1_0", 1, None),
        ("{value}", "٣", 1, None),
        ("{value}", "9" * 60_000, 1, None),
        ("T{value}T", "T", 1, None),
        ("{value}", "1", 2, None),
    ],
)
def test_what_is_taken_out_of_an_answer(answer, words, field, value):
    query = oven_settings({**WORDS, "temperature": {"query": "T?", "answer": answer, "field": field}}).temperature
    if value is not None:
        assert query.decoded(words) == value
        return
    with pytest.raises(OvenError) as caught:
        query.decoded(words)
    assert caught.value.fault is Fault.GARBLED


def test_a_ramp_in_steps(stepped):
    begun, start = stepped.clock.now(), stepped.oven.temperature()
    assert stepped.oven.ramp_to(26.0, 0.4).target == 26.0
    held = set()
    for _ in range(90):
        stepped.clock.sleep(10.0)
        ramp = min(start + 0.4 * (stepped.clock.now() - begun) / 60.0, 26.0)
        assert ramp - 0.35 <= stepped.body.target <= ramp + 0.06
        held.add(round(stepped.body.target, 3))
    assert len(held) == pytest.approx(6.0 / 0.2, abs=2)
    assert stepped.oven.hold() == pytest.approx(26.0, abs=0.1)


def test_a_ramp_in_steps_begins_near_the_air_whatever_the_set_point_was(stepped):
    points = stepped.oven._points
    points.set_point.put(60.0)
    points.run.put(True)
    air = stepped.body.measured
    assert stepped.body.target == pytest.approx(60.0)
    stepped.oven.ramp_to(40.0, 1.0)
    assert air + 4.0 < stepped.body.target < air + 6.0
    stepped.clock.sleep(120.0)
    assert air + 5.0 < stepped.body.target < air + 8.0


def test_a_held_ramp_steps_no_more(stepped):
    stepped.oven.ramp_to(40.0, 1.0)
    stepped.clock.sleep(300.0)
    assert stepped.oven.hold() == pytest.approx(25.0, abs=0.2)
    stepped.clock.sleep(600.0)
    assert stepped.body.target == pytest.approx(25.0, abs=0.2)


@pytest.mark.parametrize("end", ["safe", "close"])
def test_at_its_end_it_steps_no_more(stepped, end):
    stepped.oven.ramp_to(40.0, 1.0)
    stepped.clock.sleep(300.0)
    getattr(stepped.oven, end)()
    last = stepped.body.target
    stepped.clock.sleep(600.0)
    assert stepped.body.target == last
    assert stepped.body.regulating == (end == "close")


def test_a_step_that_is_not_taken_is_told(stepped):
    stepped.oven.ramp_to(40.0, 1.0)
    stepped.clock.sleep(60.0)
    stepped.controller.locked = True
    stepped.clock.sleep(60.0)
    with pytest.raises(OvenError, match="reads back") as caught:
        stepped.oven.temperature()
    assert caught.value.fault is Fault.NOT_TAKEN
    stepped.controller.locked = False
    stepped.oven.hold()
    assert stepped.oven.temperature() == pytest.approx(21.0, abs=0.5)


def test_steps_go_on_after_a_line_was_bad(stepped, caplog):
    stepped.oven.ramp_to(40.0, 1.0)
    stepped.clock.sleep(120.0)
    stepped.disturbed.always = silenced
    with caplog.at_level(logging.DEBUG):
        stepped.clock.sleep(60.0)
    assert "a step of the oven's ramp failed" in caplog.text
    stepped.disturbed.always = lambda answer: [answer]
    stepped.clock.sleep(60.0)
    assert stepped.body.target == pytest.approx(24.0, abs=0.3)


def test_without_a_switch_it_rests_at_a_set_point(rig_of):
    rig = rig_of("scpi", **plain(WORDS, run=None, rest_at=22.0))
    rig.oven.ramp_to(40.0, 2.0)
    rig.wait(900.0)
    rig.oven.safe()
    assert rig.body.target == 22.0
    rig.wait(7200.0)
    assert rig.oven.temperature() == pytest.approx(22.0, abs=0.2)


@pytest.mark.parametrize("kind", ["modbus-map", "scpi"])
def test_trouble_told_by_the_status_is_an_alarm(rig_of, kind):
    rig = rig_of(kind)
    rig.controller.alarm = True
    with pytest.raises(OvenError) as caught:
        rig.oven.temperature()
    assert caught.value.fault is Fault.ALARM


def test_a_damaged_status_is_no_alarm(rig_of):
    rig = rig_of("scpi")
    rig.disturbed.disturb(instead(b"GOOF\n"))
    assert rig.oven.temperature() == pytest.approx(20.0, abs=0.2)


@pytest.mark.parametrize("kind", ["modbus-map", "scpi"])
def test_stopped_on_its_panel_it_is_told(rig_of, kind):
    rig = rig_of(kind)
    rig.oven.ramp_to(30.0, 1.0)
    rig.body.stop()
    with pytest.raises(OvenError, match="stopped by itself"):
        rig.oven.temperature()


def test_a_command_that_got_lost_or_damaged_is_told_again(rig_of):
    rig = rig_of("scpi")
    inner, lost = rig.controller.receive, [b"SOUR:TEMP 41.00\n", b"SOUR:RAMP 1.000\n"]

    def receive(data):
        if data in lost:
            lost.remove(data)
            return inner(data.replace(b"4", b"6"))
        return inner(data)

    rig.controller.receive = receive
    assert rig.oven.ramp_to(41.0, 1.0).target == 41.0
    assert rig.body.target == 41.0
    assert not lost


def test_late_answers_over_tcp_are_never_taken_for_others(rig_of):
    rig = rig_of("modbus-map in Fahrenheit over TCP")
    for seconds in (0.4, 0.6, 0.9, 1.4):
        rig.disturbed.disturb(late(seconds))
        assert rig.oven.temperature() == pytest.approx(20.0, abs=0.2)


def test_a_wrong_scale_is_refused_before_anything_is_written(rig_of):
    rig = rig_of("modbus-map", **plain(REGISTERS))
    settings = oven_settings({**REGISTERS, "temperature": {"at": 1, "scale": 10.0}})
    oven = settings.open(rig.clock, MemoryTransport(rig.controller, rig.clock))
    for verb in (oven.hold, lambda: oven.ramp_to(30.0, 1.0), oven.temperature):
        with pytest.raises(OvenError, match="can be true") as caught:
            verb()
    assert caught.value.fault is Fault.REFUSED
    assert not rig.body.regulating


@pytest.fixture
def rounding(rig_of):
    """Return an oven that keeps floats, rounded to the digit it displays."""
    floats = {"set_point": {"at": 10, "type": "float32"}, "rate": {"at": 12, "type": "float32"}}
    rig = rig_of("modbus-map", **plain(REGISTERS, **floats))
    inner = rig.controller.write_words

    def write(register, words):
        inner(register, words)
        rig.controller._held.target = round(rig.controller._held.target, 1)
        rig.controller._held.rate = round(rig.controller._held.rate, 1)
        rig.controller._held.drive()

    rig.controller.write_words = write
    return rig


def test_a_float_that_the_controller_rounds_to_a_digit_is_taken(rounding):
    taken = rounding.oven.ramp_to(25.033, 0.44)
    assert (taken.target, taken.rate) == (25.0, 0.4)
    assert rounding.body.target == pytest.approx(25.0)
    assert rounding.oven.ramp_to(25.08, 0.36).target == 25.1  # written, though what it held was near


@pytest.mark.parametrize(("target", "rate"), [(30.0, 0.04), (30.0, 0.17)])
def test_a_rate_that_is_rounded_away_is_not_taken(rounding, target, rate):
    rounding.controller._held.rate = 0.0
    inner = rounding.controller.write_words

    def coarser(register, words):
        inner(register, words)
        rounding.controller._held.rate = float(round(rounding.controller._held.rate))

    rounding.controller.write_words = coarser
    with pytest.raises(OvenError, match=r"rate .*reads back 0") as caught:
        rounding.oven.ramp_to(target, rate)
    assert caught.value.fault is Fault.NOT_TAKEN


def test_a_register_that_is_not_there_is_told_by_its_key(rig_of):
    rig = rig_of("modbus-map", **plain(REGISTERS))
    settings = oven_settings({**REGISTERS, "working_set_point": {"at": 99}})
    oven = settings.open(rig.clock, MemoryTransport(rig.controller, rig.clock))
    with pytest.raises(OvenError, match="working_set_point") as caught:
        oven.temperature()
    assert "at, table and type" in caught.value.advice


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"run": None}, "neither run nor rest_at"),
        ({"rest_at": 22.0}, "both run and rest_at"),
        ({"run": None, "rest_at": 90.0}, "minimum to maximum"),
        ({"set_point": {"at": 2, "type": "uint16", "scale": 0.1}}, "set_point cannot hold minimum"),
        ({"set_point": {"at": 2, "scale": 0.001}}, "set_point cannot hold maximum"),
        ({"set_point": {"at": 2, "scale": 2.0}}, "steps of 2 K"),
        ({"set_point": {"at": 2, "scale": 0.1, "table": "input"}}, "cannot be written"),
        ({"set_point": {"at": 3}}, "both at register 3"),
        ({"set_point": {"at": 2, "type": "float32"}}, "both at register 3"),
        ({"rate": {"at": 9, "scale": 5.0}}, "steps of 5 K/min"),
        ({"rate": {"at": 9, "scale": 1e-6}}, "rate cannot hold max_rate"),
        ({"temperature": {"at": 70_000}}, "temperature.at"),
        ({"temperature": {"at": 1, "unit": "C"}}, "temperature.unit"),
        ({"framing": "ascii"}, "framing"),
        ({"word_order": "big"}, "word_order"),
    ],
)
def test_registers_that_cannot_be_are_refused(change, told):
    with pytest.raises(ValidationError, match=told):
        oven_settings({**REGISTERS, **change})


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"temperature": {"query": "TEMP?\nSET 400"}}, "printable ASCII"),
        ({"temperature": {"query": "TEMP{value}?"}}, "without braces"),
        ({"temperature": {"query": "T?", "answer": "T"}}, "once"),
        ({"temperature": {"query": "T?", "answer": "{value}{value}"}}, "once"),
        ({"set_point": {"query": "S?", "command": "S {value.__class__}"}}, "once"),
        ({"set_point": {"query": "S?", "command": "S {value} {0}"}}, "no other braces"),
        ({"set_point": {"query": "S?", "command": "S {value}", "decimals": 9}}, "decimals"),
        ({"run": {"on": "R", "off": "S", "query": "Q?", "is_on": ["0"]}}, "in is_on and in is_off"),
        ({"rate": {"query": "R?", "command": "R {value}", "scale": 100.0}}, "steps of 10 K/min"),
        ({"terminator": ";"}, "terminator"),
        ({"run": None}, "neither run nor rest_at"),
    ],
)
def test_words_that_cannot_be_are_refused(change, told):
    with pytest.raises(ValidationError, match=told):
        oven_settings({**WORDS, **change})


def test_an_endless_answer_ends():
    class Babbling:
        def write(self, data):
            pass

        def read(self, wait):
            return b"1" * 4096

        def drain(self):
            pass

        def close(self):
            pass

    line = Line(Babbling(), VirtualClock(), Timing(retries=0))
    assert len(line.exchange(b"?", lambda _: None)) < 100_000
