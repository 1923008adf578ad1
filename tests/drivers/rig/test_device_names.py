"""A device has a name in common with itself however it is written, and none with another."""

import os
import socket
from pathlib import Path
from typing import Any

import pytest

from drivers.rig.occupancy import device_names

KNOWN = {
    "gateway": ["192.0.2.7", "2001:db8::7"],
    "lab": ["192.0.2.8"],
    "this-rig": ["127.0.1.1"],
    "this-rig.lab.example": ["127.0.1.1"],
    "nowhere.example": [],
}
"""Instead of a server of names."""


@pytest.fixture(autouse=True)
def names(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = socket.getaddrinfo

    def found(host: str, *more: Any, **options: Any) -> list[Any]:
        if host not in KNOWN:
            return asked(host, *more, **options, flags=socket.AI_NUMERICHOST)
        if not KNOWN[host]:
            raise socket.gaierror(socket.EAI_NONAME, "no such name")
        return [(0, 0, 0, "", (address, 502)) for address in KNOWN[host]]

    monkeypatch.setattr(socket, "getaddrinfo", found)


def same(one: str, other: str) -> bool:
    return bool(device_names(one) & device_names(other))


@pytest.mark.parametrize(
    "spellings",
    [
        [
            "oven at socket://localhost:502",
            "oven at socket://LOCALHOST:502",
            "oven at socket://localhost.:502",
            "oven at socket://127.0.0.1:502",
            "oven at socket://127.1:502",
            "oven at socket://127.0.0.1:00502",
            "oven at socket://[::1]:502",
            "oven at socket://[0:0:0:0:0:0:0:1]:502",
            "oven at socket://[::ffff:127.0.0.1]:502",
            "oven at socket://0.0.0.0:502",
            "oven at socket://this-rig:502",
            "oven at socket://THIS-RIG.lab.example.:502",
        ],
        [
            "oven at socket://192.0.2.7:502",
            "oven at socket://[::ffff:c000:207]:502",
            "oven at socket://gateway:502",
        ],
        ["oven at socket://nowhere.example:502", "oven at socket://Nowhere.example.:502"],
        ["oven at socket://[2001:db8::1]:502", "oven at socket://[2001:DB8:0::0001]:502"],
        [
            "oven at COM3",
            "oven at com3",
            r"oven at \\.\COM3",
            "oven at //./COM3",
            r"oven at \\?\com3",
            "oven at COM3:",
        ],
        ["oven at /dev/tty.usbserial-1", "oven at /dev/cu.usbserial-1", "oven at /dev/../dev/cu.usbserial-1"],
        ["cards cDAQ1 at lab:31763", "cards cdaq1 at LAB:31763"],
        ["cards Dev1", "cards dev1"],
    ],
    ids=lambda spellings: spellings[0],
)
def test_spellings_of_one_device(spellings: list[str]) -> None:
    for one in spellings:
        for other in spellings:
            assert same(one, other), (one, other)


def test_different_devices_have_no_name_in_common() -> None:
    different = [
        "oven at socket://localhost:502",
        "oven at socket://localhost:503",
        "oven at socket://192.0.2.7:502",
        "oven at socket://nowhere.example:502",
        "thermometer at socket://localhost:502",
        "oven at COM3",
        "oven at COM30",
        "oven at /dev/ttyUSB0",
        "oven at /dev/ttyUSB1",
        "cards cDAQ1",
        "cards cDAQ1 at 192.0.2.7:31763",
        "cards cDAQ2",
    ]
    for i, one in enumerate(different):
        for other in different[i + 1 :]:
            assert not same(one, other), (one, other)


@pytest.mark.skipif(not hasattr(os, "openpty"), reason="needs a pseudo-terminal")
def test_links_to_a_port_and_the_port(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    far, near = os.openpty()
    other_far, other_near = os.openpty()
    try:
        port = os.ttyname(near)
        by_id = tmp_path / "by-id"
        by_id.symlink_to(port)
        chained = tmp_path / "oven"
        chained.symlink_to("by-id")
        monkeypatch.chdir(tmp_path)
        for spelling in (by_id, chained, tmp_path / ".." / tmp_path.name / "oven", "oven"):
            assert same(f"oven at {port}", f"oven at {spelling}")
            assert not same(f"oven at {os.ttyname(other_near)}", f"oven at {spelling}")
        number = Path(port).stat().st_rdev
        assert f"oven at character device {os.major(number)}:{os.minor(number)}" in device_names(
            f"oven at {by_id}"
        )
    finally:
        for end in (far, near, other_far, other_near):
            os.close(end)


@pytest.mark.parametrize(
    "place",
    [
        "oven at ",
        "oven at socket://",
        "oven at socket://[::1",
        "oven at socket://a:99999",
        "oven at \0",
        "oven at x:99999",
        "oven at socket://" + "a" * 300 + ":1",
    ],
)
def test_nonsense_is_its_own_name(place: str) -> None:
    assert same(place, place)
    assert not same(place, "oven at COM3")
