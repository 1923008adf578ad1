from pathlib import Path

from app.files.campaign_error import SHOWN, CampaignFileError, Problem


def test_one_problem_is_one_line() -> None:
    error = CampaignFileError(
        Path("plate"), [Problem("campaign.toml", "plate.mass", "-1", "above 0 (kg)", "weigh it")]
    )
    assert str(error) == "plate: campaign.toml: plate.mass = -1; allowed: above 0 (kg) (weigh it)"


def test_long_lists_are_cut_and_counted_and_kept() -> None:
    error = CampaignFileError(Path("plate"), [Problem(f"{n}", "", "gone", "there") for n in range(100)])
    lines = str(error).splitlines()
    assert lines[0] == "plate: 100 problems"
    assert lines[-1].strip() == f"... and {100 - SHOWN} more"
    assert len(lines) == SHOWN + 2
    assert len(error.problems) == 100
