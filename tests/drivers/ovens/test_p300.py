"""Espec's words to values and back."""

import pytest

from drivers.ovens import espec
from drivers.ovens.error import Fault, OvenError
from drivers.ovens.espec import Monitored, Program, Temperatures


def test_commands():
    assert espec.command("TEMP?") == b"TEMP?\r\n"
    assert espec.set_temperature(25.0) == b"TEMP, S25.0\r\n"
    assert espec.set_temperature(-5.25) == b"TEMP, S-5.2\r\n"
    assert Program(25.0, -40.0, 150).encode() == b"RUN PRGM, TEMP25.0 GOTEMP-40.0 TIME2:30\r\n"
    assert Program(20.0, 20.4, 1).encode() == b"RUN PRGM, TEMP20.0 GOTEMP20.4 TIME0:01\r\n"


@pytest.mark.parametrize("answer", [b"25.3,-5.0,100.0,-40.0\r\n", b"25.3, -5.0, 100.0, -40.0\r\n"])
def test_temperatures(answer):
    assert espec.decode_temperatures(answer) == Temperatures(25.3, -5.0, 100.0, -40.0)


@pytest.mark.parametrize(
    ("answer", "seen"),
    [
        (b"23.0,CONSTANT,0\r\n", Monitored(23.0, "CONSTANT", 0)),
        (b"-12.5, 85, RUN 1, 2\r\n", Monitored(-12.5, "RUN 1", 2)),
        (b"24.8, STANDBY, 0\r\n", Monitored(24.8, "STANDBY", 0)),
    ],
)
def test_monitored(answer, seen):
    assert espec.decode_monitored(answer) == seen


@pytest.mark.parametrize(
    "answer",
    [
        b"TEMP20.0 GOTEMP60.0 TIME1:40 REF9\r\n",
        b"TEMP20.0 GOTEMP60.0 HUMI85 GOHUMI100 TIME1:40 REF9 RELAYON,1\r\n",
        b"TEMP20.0, GOTEMP60.0, TIME1:40\r\n",
    ],
)
def test_program(answer):
    assert espec.decode_program(answer) == Program(20.0, 60.0, 100)


@pytest.mark.parametrize("answer", [b"OK\r\n", b"OK:TEMP, S25.0\r\n", b"OK: MODE, CONSTANT\r\n"])
def test_done(answer):
    espec.decode_done(answer)


@pytest.mark.parametrize(
    ("answer", "told"),
    [
        (b"NA:CMD ERR\r\n", "firmware"),
        (b"NA:DATA OUT OF RANGE\r\n", "limits"),
        (b"NA:PROTECT ON\r\n", "protection"),
        (b"NA:SOMETHING NEW\r\n", "panel"),
    ],
)
def test_refusals_say_what_to_do(answer, told):
    with pytest.raises(OvenError) as caught:
        espec.decode_done(answer)
    assert caught.value.fault is Fault.REFUSED
    assert caught.value.code == answer.decode().strip()
    assert told in caught.value.advice


@pytest.mark.parametrize("what", ["DATA", "CHB", "CONT"])
def test_what_is_not_ready_may_be_asked_for_again(what):
    with pytest.raises(OvenError) as caught:
        espec.decode(f"NA:{what} NOT READY\r\n".encode())
    assert caught.value.fault is Fault.BUSY
    assert caught.value.advice != "Look at the chamber's panel."


@pytest.mark.parametrize(
    ("decode", "answer"),
    [
        (espec.decode_temperatures, b"25.3,25.0,100.0\r\n"),
        (espec.decode_temperatures, b"25.3,25.0,100.0,-4\xc00.0\r\n"),
        (espec.decode_temperatures, b"25.3,25.0,100.0,-40.0"),
        (espec.decode_temperatures, b"2503,25.0,100.0,-40.0\r\n"),
        (espec.decode_monitored, b"23.0,CONSTBNT,0\r\n"),
        (espec.decode_monitored, b"23.0,CONSTANT\r\n"),
        (espec.decode_program, b"TEMP20.0 TIME1:40\r\n"),
        (espec.decode_done, b"OJ:TEMP, S25.0\r\n"),
        (espec.decode_done, b"25.3,25.0,100.0,-40.0\r\n"),
    ],
)
def test_answers_that_are_none(decode, answer):
    with pytest.raises(OvenError) as caught:
        decode(answer)
    assert caught.value.fault is Fault.GARBLED


def test_silence_is_told_apart():
    with pytest.raises(OvenError) as caught:
        espec.decode_temperatures(b"")
    assert caught.value.fault is Fault.SILENT
