"""What goes through the pipe comes out the same, and nonsense is no message."""

import io

import pytest

from drivers.ovens.error import Fault, OvenError
from drivers.rig.end_requests import RigStopped
from drivers.watchdog.frames import LONGEST, Messages, packed, received, unpacked


@pytest.mark.parametrize(
    "error",
    [
        OvenError(Fault.ALARM, "a broken sensor", "look", "E5"),
        OvenError(Fault.SILENT, "nothing – at 5 °C", "look"),
        RigStopped("enough", "go on later"),
        ValueError("rate 0 K/min"),
    ],
)
def test_errors_travel(error: Exception) -> None:
    pipe = io.BytesIO()
    assert Messages(pipe).send(error=packed(error))
    pipe.seek(0)
    line = received(pipe)
    assert line is not None
    there = unpacked(line["error"])
    assert (type(there), str(there)) == (type(error), str(error))


def test_a_defect_is_said_as_such() -> None:
    assert "KeyError" in str(unpacked(packed(KeyError("x"))))


@pytest.mark.parametrize("data", [b"", b"{", b"[1]\n", b"{}", b"x\n", b"\xff\n", b'{"a":' + b"1" * 2 * LONGEST])
def test_nonsense_is_the_end(data: bytes) -> None:
    assert received(io.BytesIO(data)) is None


def test_a_closed_pipe_takes_nothing() -> None:
    pipe = io.BytesIO()
    lines = Messages(pipe)
    lines.close()
    assert not lines.send(age=1.0)
