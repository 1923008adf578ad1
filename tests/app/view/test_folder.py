import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from app.files.bad_file import ResultFileError
from app.main import flexura
from app.view.folder import Viewed, viewed


def test_a_campaign_goes_with_the_run_beside_it(run: Path) -> None:
    campaign = run.with_name("plate")
    campaign.mkdir()
    (campaign / "protocol.json").write_text("{}", encoding="utf-8")
    assert viewed(campaign).run == run.resolve()
    assert viewed(run).campaign is None
    (run / "frf.h5").rename(run.parent / "away")
    for name in ("modes.h5", "laws.h5"):
        (run / name).unlink()
    assert viewed(campaign).run is None


def test_a_folder_that_is_neither_is_refused_with_what_would_do(tmp_path: Path) -> None:
    with pytest.raises(ResultFileError, match="holds neither a campaign nor results; name a campaign"):
        viewed(tmp_path)
    shown = CliRunner().invoke(flexura, ["view", str(tmp_path / "nowhere")])
    assert shown.exit_code != 0
    assert "does not exist" in shown.output


def test_the_run_of_a_modal_test_can_be_looked_at(tmp_path: Path) -> None:
    (tmp_path / "transfers.h5").touch()
    assert viewed(tmp_path) == Viewed(None, tmp_path)


def test_help_needs_no_qt() -> None:
    asked = "import sys; from app.main import flexura; flexura(['view', '--help'], standalone_mode=False);" + (
        "print('PySide6' in sys.modules)"
    )
    told = subprocess.run([sys.executable, "-c", asked], capture_output=True, text=True, check=True)
    assert told.stdout.rstrip().endswith("False")
