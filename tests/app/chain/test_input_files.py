"""What a stage reads is known by its content: options of a run are no part of a declaration, a named mesh is."""

import hashlib
import os
import signal
from pathlib import Path

import pytest

from app.chain.work import campaign_hashes, file_hashes
from app.files.acquisition.events import append_event
from app.files.campaigns.channels import declaration_digest
from app.files.campaigns.loading import load_campaign
from app.terminal.end_signals import end_signals, held_back
from tests.app.conftest import TinyCampaign

TABLE = '\n[run]\nwithout = ["gap"]\n\n[run.focus]\ntaps = 64\n'


def test_hashes_are_those_of_the_campaign_as_read(tiny: TinyCampaign, tmp_path: Path) -> None:
    folder = tiny.write(tmp_path / "tiny")
    assert campaign_hashes(folder) == load_campaign(folder).hashes


def test_a_table_run_changes_no_hash(tiny: TinyCampaign, tmp_path: Path) -> None:
    folder = tiny.write(tmp_path / "tiny")
    before = load_campaign(folder).hashes
    path = folder / "campaign.toml"
    text = path.read_text(encoding="utf-8")
    assert before["campaign.toml"] == hashlib.sha256(path.read_bytes()).hexdigest()
    path.write_text(text + TABLE, encoding="utf-8")
    assert load_campaign(folder).hashes == before == campaign_hashes(folder)
    path.write_text(text.replace("[plate]", f"{TABLE.lstrip()}\n[plate]"), encoding="utf-8")
    between = declaration_digest(path)
    path.write_text(text.replace("[plate]", f"{TABLE.lstrip().replace('64', '32')}\n[plate]"), encoding="utf-8")
    assert declaration_digest(path) == between
    path.write_text(text.replace("mass = 0.13", "mass = 0.14") + TABLE, encoding="utf-8")
    assert load_campaign(folder).hashes["campaign.toml"] != before["campaign.toml"]


def test_brackets_in_a_text_are_no_table(tiny: TinyCampaign, tmp_path: Path) -> None:
    folder = tiny.write(tmp_path / "tiny")
    path = folder / "campaign.toml"
    text = path.read_text(encoding="utf-8").replace('title = "tiny plate"', 'title = """\n[run]\ntiny"""')
    path.write_text(text + TABLE, encoding="utf-8")
    first = declaration_digest(path)
    path.write_text(text.replace("tiny", "other") + TABLE, encoding="utf-8")
    assert declaration_digest(path) != first


def test_a_mesh_that_a_panel_names_belongs_to_it(tmp_path: Path) -> None:
    (tmp_path / "panel.toml").write_text('[plate.mesh]\nfile = "panel.msh"\n', encoding="utf-8")
    alone = file_hashes(tmp_path / "panel.toml")
    (tmp_path / "panel.msh").write_text("1", encoding="utf-8")
    first = file_hashes(tmp_path / "panel.toml")
    (tmp_path / "panel.msh").write_text("2", encoding="utf-8")
    assert len({str(alone), str(first), str(file_hashes(tmp_path / "panel.toml"))}) == 3
    assert file_hashes(tmp_path / "nowhere.toml") == {}


def test_a_temperature_that_is_doubted_later_makes_another_campaign(tmp_path: Path) -> None:
    (tmp_path / "sweeps").mkdir()
    (tmp_path / "protocol.json").write_text("{}", encoding="utf-8")
    before = campaign_hashes(tmp_path)
    append_event(tmp_path, {"event": "sweep", "step": 1})
    assert campaign_hashes(tmp_path) == before
    append_event(tmp_path, {"event": "temperature in doubt", "step": 1, "what": ["the sensor fell off"]})
    assert campaign_hashes(tmp_path) != before


def test_a_signal_waits_until_the_files_are_written() -> None:
    done: list[str] = []

    def write() -> None:
        with held_back():
            for name in ("first", "second"):
                os.kill(os.getpid(), signal.SIGINT)
                done.append(name)

    with pytest.raises(KeyboardInterrupt):
        write()
    assert done == ["first", "second"]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_a_second_signal_at_the_end_interrupts_nothing_any_more() -> None:
    """It was a traceback of sixty lines after the sentence that said "stopped"."""
    with end_signals() as ends:
        with pytest.raises(KeyboardInterrupt):
            os.kill(os.getpid(), signal.SIGINT)
        ends.over = True  # as where handlers are put back
        os.kill(os.getpid(), signal.SIGINT)
    assert ends.status == 130
