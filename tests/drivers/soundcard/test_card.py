"""A sound card's driver on a stand-in for its package: aligned, calibrated, and at rest whatever happens."""

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError
from scipy.signal import butter, sosfilt, sosfreqz

from analysis.arrays import Real
from drivers.clock import VirtualClock
from drivers.ni.cards import CARDS, Action, DaqError
from drivers.rig.survey import FindingState, look_at_sound
from drivers.soundcard.card import SoundCard, SoundCards
from drivers.soundcard.simulated import PortAudioError, SimulatedSound, simulated_sound

RATE = 44_100.0
SECTIONS = butter(1, [300.0, 900.0], btype="bandpass", fs=RATE, output="sos")


def plate(drive: Real, rate: float, temperature: Real) -> Real:
    return np.asarray(sosfilt(SECTIONS, drive)[None])


@pytest.fixture
def settings() -> SoundCard:
    return SoundCard(
        output="out1", drive_input="in1", responses=("in2",), sample_rate=RATE, input_range=2.5, output_range=2.0
    )


@pytest.fixture
def sound(settings: SoundCard) -> SimulatedSound:
    return simulated_sound(settings, plate, VirtualClock(), seed=4)


@pytest.fixture
def cards(settings: SoundCard, sound: SimulatedSound) -> SoundCards:
    return SoundCards(settings, sound, sound.clock)


@pytest.fixture
def drive() -> Real:
    time = np.arange(int(RATE)) / RATE
    fade = np.minimum(1.0, np.minimum(time, time[::-1]) / 0.05)
    return np.append(np.sin(2.0 * np.pi * (100.0 * time + 700.0 * time**2)) * fade, np.zeros(20_000))


def test_is_one_of_the_kinds_of_cards() -> None:
    assert CARDS.find("soundcard") is SoundCard


def test_ratio_to_the_recorded_drive_is_the_plate(cards: SoundCards, drive: Real) -> None:
    record = cards.sweep(drive)
    assert record.drive.shape == drive.shape
    assert (record.sample_rate, record.full_scale) == (RATE, 2.5)
    grid = np.fft.rfftfreq(drive.size, 1.0 / RATE)
    inside = (grid > 150.0) & (grid < 1300.0)
    ratio = (np.fft.rfft(record.responses[0]) / np.fft.rfft(record.drive))[inside]
    assert np.abs(ratio - sosfreqz(SECTIONS, grid[inside], fs=RATE)[1]).max() < 1e-3
    assert np.abs(record.drive).max() == pytest.approx(1.0, abs=1e-3)


def test_every_sweep_begins_at_the_same_sample_though_streams_do_not(cards: SoundCards, drive: Real) -> None:
    first, second = cards.sweep(drive).drive, cards.sweep(drive).drive
    assert np.abs(first - second).max() < 3e-4  # noise alone


def test_silence_before_the_first_sweep_leaves_all_others_aligned(
    cards: SoundCards, sound: SimulatedSound, drive: Real
) -> None:
    """Of a delay that ends on half a sample, noise would decide which sample is the first."""
    sound.latency = 1234.5
    sound.noise = 1e-3
    assert cards.sweep(np.zeros(drive.size)).drive.shape == drive.shape
    first, *others = (cards.sweep(drive).drive for _ in range(12))
    for other in others:
        assert np.abs(first - other).max() < 0.01  # noise alone; a sample is worth 0.2 V


def test_lost_samples_call_for_another_sweep(cards: SoundCards, sound: SimulatedSound, drive: Real) -> None:
    sound.xruns.append(sound.streams + 1)
    with pytest.raises(DaqError, match="Samples were lost: input overflow") as caught:
        cards.sweep(drive)
    assert caught.value.action is Action.RETRY_DISCARD
    assert sound.voltage() == 0.0
    cards.sweep(drive)


@pytest.mark.parametrize("error", [KeyboardInterrupt, OSError])
def test_whatever_ends_a_sweep_the_output_is_at_rest(
    cards: SoundCards, sound: SimulatedSound, error: type[BaseException]
) -> None:
    voltages: list[float] = []

    def check() -> None:
        voltages.append(sound.voltage())
        if len(voltages) == 3:
            raise error

    with pytest.raises(error):
        cards.sweep(np.full(round(RATE), 1.5), check)
    assert voltages == [pytest.approx(1.5)] * 3
    assert sound.voltage() == 0.0


def test_a_device_that_is_gone_is_said(cards: SoundCards, sound: SimulatedSound, drive: Real) -> None:
    sound.gone = True
    with pytest.raises(DaqError, match="Device unavailable") as caught:
        cards.sweep(drive)
    assert caught.value.action is Action.LOST_DEVICE
    with pytest.raises(DaqError):
        cards.close()


def test_a_missing_loop_back_is_found_at_the_first_sweep_and_hinders_no_rest(
    settings: SoundCard, sound: SimulatedSound, drive: Real
) -> None:
    sound.drive_scale = 0.0
    sound.plate = lambda volts, rate, temperature: pytest.fail("a sound is played on the way to rest")
    cards = SoundCards(settings, sound, sound.clock)
    cards.close()
    sound.plate = plate
    for _ in range(2):
        with pytest.raises(DaqError, match="the loop-back test from out1 to in1") as caught:
            cards.sweep(drive)
        assert caught.value.action is Action.STOP


def test_a_stream_that_does_not_end_is_a_lost_device(
    cards: SoundCards, sound: SimulatedSound, drive: Real, monkeypatch: pytest.MonkeyPatch
) -> None:
    cards.sweep(drive)
    asked = 0

    def still_active(self: SimulatedSound) -> bool:
        nonlocal asked
        asked += 1
        assert asked < 1000, "it is waited for without end"
        return True

    monkeypatch.setattr(SimulatedSound, "active", property(still_active))
    for play in (lambda: cards.sweep(drive), cards.close):
        begun = sound.clock.now()
        with pytest.raises(DaqError, match="does not end") as caught:
            play()
        assert caught.value.action is Action.LOST_DEVICE
        assert sound.clock.now() - begun < drive.size / RATE + 6.0


def test_the_loop_back_calibrates_the_inputs(settings: SoundCard, sound: SimulatedSound, drive: Real) -> None:
    """Inputs of 3 V declared as of 2.5 V show too little; the message says what fits, and with that it opens."""
    sound.input_range = 3.0
    with pytest.raises(DaqError, match=r"cards.input_range is 3 V instead of 2.5 V"):
        SoundCards(settings, sound, sound.clock).sweep(drive)
    fitting = settings.model_copy(update={"input_range": 3.0})
    record = SoundCards(fitting, sound, sound.clock).sweep(drive)
    assert np.abs(record.drive).max() == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize("wrong", [np.zeros(1), np.zeros((2, 9)), np.full(9, np.nan), np.full(9, 2.1)])
def test_a_drive_that_cannot_be_played_is_refused(cards: SoundCards, wrong: Real) -> None:
    with pytest.raises(ValueError, match=r"allowed|allows"):
        cards.sweep(wrong)


def test_channels_are_named_and_used_once(settings: SoundCard) -> None:
    declared: dict[str, Any] = settings.model_dump()
    for changes in ({"responses": ["in1"]}, {"responses": ["ai0"]}, {"output": "in2"}):
        with pytest.raises(ValidationError):
            SoundCard(**{**declared, **changes})


def test_clipping_is_seen(settings: SoundCard, sound: SimulatedSound, drive: Real) -> None:
    cards = SoundCards(settings, sound, sound.clock)
    sound.plate = lambda volts, rate, temperature: 4.0 * volts[None]
    assert cards.sweep(drive).overloaded.tolist() == [False, True]


class Listing:
    """What the package says of the devices."""

    PortAudioError = PortAudioError

    def query_devices(self, name: str | None, kind: str) -> dict[str, Any]:
        if name == "no such":
            raise ValueError("No input device matching 'no such'")
        if name == "unplugged":
            raise PortAudioError("Error querying device -1")
        return {"name": "Box", "max_input_channels": 2, "max_output_channels": 2}


@pytest.mark.parametrize(
    ("changes", "state", "told"),
    [
        ({}, FindingState.GOOD, "Box, 2 inputs, 2 outputs"),
        ({"responses": ("in4",)}, FindingState.BAD, "in4"),
        ({"device": "no such"}, FindingState.BAD, "python -m sounddevice"),
        ({"device": "unplugged"}, FindingState.BAD, "PortAudio fails: Error querying device -1 start this"),
    ],
)
def test_doctor_counts_its_channels(
    settings: SoundCard, changes: dict[str, Any], state: FindingState, told: str
) -> None:
    found = look_at_sound(settings.model_copy(update=changes), needed=True, sound=Listing())
    assert found.state is state
    assert told in f"{found.seen} {found.next_step}"


def test_doctor_says_so_where_the_sound_system_does_not_start(
    settings: SoundCard, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """PortAudio is started while the package is loaded: its error is of a class that nobody can name yet."""
    module = "class PortAudioError(Exception):\n    pass\nraise PortAudioError('Error initializing PortAudio')\n"
    (tmp_path / "sounddevice.py").write_text(module, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "sounddevice", raising=False)
    found = look_at_sound(settings, needed=True)
    assert found.state is FindingState.BAD
    assert "Error initializing PortAudio" in found.seen
    assert "start this computer's sound system" in found.next_step
