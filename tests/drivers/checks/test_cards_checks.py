"""The checks of cards: NI's pass them on the simulated chassis, and each defect is found by one."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.files.campaign_error import CampaignFileError
from app.files.declarations.instruments import declared_instruments
from drivers.checks import cards as trials
from drivers.checks.cards import check_cards, check_real_cards
from drivers.checks.instruments import NoCounterpart
from drivers.ni.cards import CardsSettings, DaqError, Record
from drivers.ni.daqmx import DaqmxCards
from drivers.ni.wiring import Wiring

EXAMPLES = sorted((Path(__file__).resolve().parents[3] / "examples").glob("*.toml"))
WIRING = Wiring(
    output="cDAQ1Mod2/ao0",
    drive_input="cDAQ1Mod1/ai0",
    responses=("cDAQ1Mod1/ai1", "cDAQ1Mod1/ai2"),
    thermocouples=("cDAQ1Mod3/ai0",),
    sample_rate=8500.0,
)


def failures(found: Any) -> dict[str, str]:
    return {one.name: one.said for one in found if one.result == "FAILED"}


def test_our_own_pass() -> None:
    assert [(one.result, one.said) for one in check_cards(WIRING)] == [("passed", "")] * 8


@pytest.mark.parametrize(
    "path", [path for path in EXAMPLES if "[cards]" in path.read_text()], ids=lambda path: path.stem
)
def test_those_of_the_examples_pass(path: Path) -> None:
    if path.stem == "hammer-rig":  # its cards only record
        with pytest.raises(CampaignFileError, match="the first hit checks them"):
            declared_instruments(str(path))
        return
    cards = declared_instruments(str(path)).cards
    assert cards is not None
    if not isinstance(cards, Wiring):  # a sound card is checked with --really
        with pytest.raises(NoCounterpart):
            check_cards(cards)
        return
    assert failures(check_cards(cards)) == {}


class Defective(DaqmxCards):
    """Real enough, but for one defect."""

    defect = ""

    def zero(self) -> None:
        if self.defect != "never zero":
            super().zero()

    def sweep(self, drive: Any, check: Any = lambda: None) -> Record:
        if self.defect == "deaf":
            check = lambda: None  # noqa: E731
        if self.defect == "clips":
            drive = np.clip(np.nan_to_num(np.ravel(drive)), -4.24, 4.24)
        try:
            record = super().sweep(drive, check)
        except DaqError:
            if self.defect != "makes it up":
                raise
            return Record(drive, np.tile(drive, (2, 1)), self.sample_rate, 5.0)
        if self.defect == "short":
            return Record(record.drive[:-1], record.responses[:, :-1], record.sample_rate, record.full_scale)
        return record

    def temperatures(self) -> Any:
        return np.empty(0) if self.defect == "no thermocouples" else super().temperatures()

    def close(self) -> None:
        super().close()
        if self.defect == "once" and self.__dict__.setdefault("closed", 0):
            raise RuntimeError("closed already")
        self.__dict__["closed"] = 1


@pytest.mark.parametrize(
    ("defect", "found"),
    [
        ("never zero", "a drive can be broken off"),
        ("deaf", "a drive can be broken off"),
        ("clips", "wrong drives are refused"),
        ("makes it up", "lost cards are reported"),
        ("short", "plays and records"),
        ("no thermocouples", "thermocouples as declared"),
        ("once", "closes twice, at 0 V"),
    ],
)
def test_every_defect_is_found(defect: str, found: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(trials, "DaqmxCards", Defective)
    monkeypatch.setattr(Defective, "defect", defect)
    assert found in failures(check_cards(WIRING))


def test_other_cards_bring_no_chassis() -> None:
    class Sound(CardsSettings):
        pass

    for settings in (
        Sound(kind="sound", responses=("1",), sample_rate=48e3),
        WIRING.model_copy(update={"output": "Dev1/ao0"}),
        WIRING.model_copy(update={"output": "cDAQ2Mod2/ao0"}),
    ):
        with pytest.raises(NoCounterpart):
            check_cards(settings)


def test_real_ones_play_a_hundredth(monkeypatch: pytest.MonkeyPatch) -> None:
    played: list[float] = []

    class Loose:
        sample_rate = 8000.0

        def sweep(self, drive: Any, check: Any = lambda: None) -> Record:
            if np.ndim(drive) != 1 or not np.isfinite(drive).all() or np.abs(drive).max() > WIRING.output_range:
                raise ValueError
            played.append(float(np.abs(drive).max()))
            check()
            return Record(drive, np.tile(drive, (2, 1)), 8000.0, 5.0)

        def temperatures(self) -> Any:
            return np.array([20.0])

        def zero(self) -> None:
            pass

        def close(self) -> None:
            pass

    monkeypatch.setattr(Wiring, "open", lambda self: Loose())
    found = list(check_real_cards(WIRING))
    assert failures(found) == {}
    assert max(played) <= 0.0101 * WIRING.output_range
    assert {one.name for one in found if one.result == "not checked"} >= {"lost cards are reported"}
