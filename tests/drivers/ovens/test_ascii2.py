"""ASCII-2 bytes to values and back."""

import math

import pytest

from drivers.ovens import votsch
from drivers.ovens.error import Fault, OvenError
from drivers.ovens.votsch import Ascii2Channel, Ascii2Layout, Status

# A chamber without humidity, four bits, in another order of channels than the simulated one.
SMALL = (
    b"ASCII 2 PROTOCOL FOR E-STRING\r\n$01E SV01 CV01 MV01 DO00 DO01 DO02 DO03 <CR>\r\n DESCRIPTION: \r\n"
    b"SV01  value min:   10.0   Value max:  100.0   Fan\r\n"
    b"CV01  value min:  -77.0   Value max:  182.0   Temperature \r\nMV01  0000.0 unused\r\n"
    b"DO00  unused\r\nDO01  unused\r\nDO02  Start\r\nDO03  Dryer\r\n"
    b"ASCII 2 PROTOCOL FOR I-STRING\r\nSV01 SV01 CV01 CV01 MV01 MV01 DO00 DO01 DO02 DO03 DESCRIPTION: \r\n"
    b"SV01  set value     Fan\r\nCV01  nominal value Temperature\r\nCV01  actual value  Temperature\r\n"
    b"DO02  Start\r\n"
)
LAYOUT = Ascii2Layout(
    (
        Ascii2Channel("SV01", "Fan", 10.0, 100.0),
        Ascii2Channel("CV01", "Temperature", -77.0, 182.0),
        Ascii2Channel("MV01", "0000.0 unused", -math.inf, math.inf),
    ),
    ("unused", "unused", "Start", "Dryer"),
)


def test_description():
    layout = votsch.decode_description(SMALL)
    assert layout == LAYOUT
    assert (layout.temperature, layout.start, layout.controls) == (1, 2, 1)


@pytest.mark.parametrize("end", [b"\r", b"\n", b"\r\n"])
def test_description_with_any_line_ends(end):
    assert votsch.decode_description(SMALL.replace(b"\r\n", end)) == LAYOUT


def test_a_line_of_names_describes_nothing():
    names = b"SV01 CV01 MV01 DO00 DO01 DO02 DO03 <CR>\r\nDO00 DO01 DO02 DO03 <CR>\r\n"
    assert votsch.decode_description(SMALL.replace(b"ASCII 2 PROTOCOL FOR I", names + b"I")) == LAYOUT


@pytest.mark.parametrize(
    "answer",
    [b"ASCII description of the protocol\r", SMALL.replace(b"DO01", b"DO07"), SMALL[:140]],
)
def test_description_that_is_none(answer):
    with pytest.raises(OvenError) as caught:
        votsch.decode_description(answer)
    assert caught.value.fault is Fault.GARBLED


@pytest.mark.parametrize(
    ("old", "new", "told"), [(b"Temperature", b"Pressure", "temperature"), (b"Start", b"Go", "Start")]
)
def test_layout_that_cannot_be_used(old, new, told):
    layout = votsch.decode_description(SMALL.replace(old, new))
    with pytest.raises(OvenError, match=told) as caught:
        _ = (layout.temperature, layout.start)
    assert caught.value.fault is Fault.REFUSED


def test_status():
    answer = b"0080.0 0079.5 -005.2 -004.9 0000.0 0023.8 0010\r"
    assert votsch.decode_status(answer, LAYOUT) == Status((80.0, -5.2, 0.0), (79.5, -4.9, 23.8), "0010")


@pytest.mark.parametrize(
    "answer",
    [
        b"0080.0 0079.5 -005.2 -004.9 0000.0 0023.8 001\r",  # a bit short
        b"0080.0 0079.5 -005.2 -004.9 0000.0 0010\r",  # a value short
        b"0080.0 0079.5 -0\x055.2 -004.9 0000.0 0023.8 0010\r",
        b"\xff0080.0 0079.5 -005.2 -004.9 0000.0 0023.8 0010\r",
        b"0080.0 0079.5 -005.2 -004.9 0000.0 0023.8 0012\r",
        b"0080.0 0079.5 -005.2 -00",
        b"0\r",
    ],
)
def test_status_that_is_none(answer):
    with pytest.raises(OvenError) as caught:
        votsch.decode_status(answer, LAYOUT)
    assert caught.value.fault is Fault.GARBLED


def test_silence_is_told_apart():
    with pytest.raises(OvenError) as caught:
        votsch.decode_status(b"", LAYOUT)
    assert caught.value.fault is Fault.SILENT


def test_commands():
    assert votsch.encode_query(1, "I") == b"$01I\r"
    assert votsch.encode_query(12, "?") == b"$12?\r"
    assert votsch.encode_status(1, (23.1, -5.2, 100.0), "0100") == b"$01E 0023.1 -005.2 0100.0 0100\r"
    assert votsch.encode_gradients(1, (0.4, 0.4, 0.0, 0.0)) == b"$01U 0000.4 0000.4 0000.0 0000.0\r"


def test_acknowledgements():
    votsch.decode_acknowledgement(b"0\r")
    with pytest.raises(OvenError) as refused:
        votsch.decode_acknowledgement(b"2\r")
    assert (refused.value.fault, refused.value.code) == (Fault.REFUSED, "2")
    with pytest.raises(OvenError) as garbled:
        votsch.decode_acknowledgement(b"\x80\r")
    assert garbled.value.fault is Fault.GARBLED


# As of a chamber with an external cabinet: other wording, and its shifts, which nothing measures, are read once.
CABINET = (
    b"ASCII-2 PROTOCOL CONFIGURATION\r\n\r\nExample of an ASCII E-String:\r\n"
    b"$01E CV01 CV02 SV01 SV02 MV01 DO00 DO01 <CR>\r\n\r\nDescription:\r\n"
    b"CV01  value min:  -77.0   value max:  182.0   Temperature\r\n"
    b"CV02  value min:  -55.0   value max:  150.0   T.external\r\n"
    b"SV01  value min:    2.0   value max:   30.0   T.shift\r\n"
    b"SV02  value min:    2.0   value max:   30.0   T.shift\r\n"
    b"MV01  0000.0 unused setpoint\r\nDO00  unused\r\nDO01  Start\r\n" + b"-" * 80 + b"\r\n"
    b"Example of  an ASCII I-String:\r\n$01I<CR>\r\n"
    b"CV01 CV01 CV02 CV02 SV01 SV02 MV01 MV01 DO00 DO01 <CR>\r\n\r\nDescription:\r\n"
    b"CV01  nominal value Temperature\r\nCV01  actual value  Temperature\r\nSV01  set value     T.shift\r\n"
    b"MV01 unused setpoint\r\nMV01  not supported\r\nDO00  unused\r\nDO01  Start\r\n"
    b"Configured Messages:\r\nnone\r\n"
)


def test_a_description_in_which_some_values_are_read_once():
    layout = votsch.decode_description(CABINET)
    assert [channel.name for channel in layout.channels] == ["CV01", "CV02", "SV01", "SV02", "MV01"]
    assert (layout.temperature, layout.start, layout.controls) == (0, 1, 2)
    status = votsch.decode_status(b"0050.0 0024.6 0030.0 0028.1 0005.0 0006.0 0000.0 0023.8 01\r", layout)
    assert status == Status((50.0, 30.0, 5.0, 6.0, 0.0), (24.6, 28.1, 5.0, 6.0, 23.8), "01")


def dynamic(separator: str) -> bytes:
    """As of a chamber of configuration type DYNAMIC: sensors and six bits are read only, lines end at 80."""
    written = ["CV01", "CV02", "SV01", "SV02", "SV03"]
    read = ["CV01", "CV01", "CV02", "CV02", "SV01", "SV02", "SV03", "MV01", "MV02", "MV03", "MV04"]

    def row(names: list[str], bits: int) -> str:
        whole = " ".join(names) + " " + separator.join(f"DO{i:02d}" for i in range(bits)) + separator + "<CR>"
        return "\r\n".join(whole[i : i + 80] for i in range(0, len(whole), 80))

    labels = [f"DO{i:02d}  {'Start' if i == 1 else 'Option'}" for i in range(26)]
    lines = [
        "ASCII-2 PROTOCOL CONFIGURATION",
        "Configuration type: DYNAMIC",
        "Show target setpoint: disabled",
        "Example of an ASCII E-String:",
        f"$01E {row(written, 26)}",
        "Description:",
        "CV01  value min:  -72.0   value max:  182.0   Temperature",
        "CV02  value min:    0.0   value max:   98.0   Humidity",
        *(f"SV{i:02d}  value min:    0.0   value max:   30.0   Option" for i in (1, 2, 3)),
        *labels,
        "-" * 80,
        "Example of  an ASCII I-String:",
        "$01I<CR>",
        row(read, 32),
        "Description:",
        "CV01  nominal value Temperature",
        "CV01  actual value  Temperature",
        "SV01  set value     Option",
        "MV01 actual value T.sensor 1",
        *labels,
        *(f"DO{i:02d}  unused" for i in range(26, 32)),
        "Configured Messages:",
        "none",
    ]
    return "\r\n".join(lines).encode("ascii") + b"\r\n"


@pytest.mark.parametrize("separator", [" ", ""])
def test_a_description_in_which_more_is_read_than_is_written(separator):
    layout = votsch.decode_description(dynamic(separator))
    assert [channel.name for channel in layout.channels] == ["CV01", "CV02", "SV01", "SV02", "SV03"]
    assert (layout.temperature, layout.start, len(layout.bits), layout.reported_bits) == (0, 1, 26, 32)
    values = b"0050.0 0024.6 0080.0 0066.7 0025.0 0001.0 0002.0 0021.1 0021.2 0021.3 0021.4 "
    status = votsch.decode_status(values + b"01" + b"0" * 29 + b"1\r", layout)
    assert status == Status((50.0, 80.0, 25.0, 1.0, 2.0), (24.6, 66.7, 25.0, 1.0, 2.0), "01" + "0" * 24)
    assert votsch.encode_status(1, status.nominal, status.bits).split()[-1] == b"01" + b"0" * 24


def test_bits_that_are_not_all_there():
    layout = votsch.decode_description(dynamic(""))
    with pytest.raises(OvenError):
        votsch.decode_status(b"0001.0 " * 11 + b"0" * 26 + b"\r", layout)
