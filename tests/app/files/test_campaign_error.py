from pathlib import Path

from app.files.campaign_error import LINES_SHOWN, CampaignFileError, Problem


def test_one_problem_is_one_line() -> None:
    error = CampaignFileError(
        Path("plate"), [Problem("campaign.toml", "plate.mass", "-1", "above 0 (kg)", "weigh it")]
    )
    assert str(error) == "plate: campaign.toml: plate.mass = -1; allowed: above 0 (kg) (weigh it)"


def test_long_lists_are_cut_and_counted_and_kept() -> None:
    error = CampaignFileError(Path("plate"), [Problem("a", "", f"gone {n}", "there") for n in range(100)])
    lines = str(error).splitlines()
    assert lines[0] == "plate: 100 problems"
    assert lines[-1].strip() == f"... and {100 - LINES_SHOWN} more"
    assert len(lines) == LINES_SHOWN + 2
    assert len(error.problems) == 100


def test_the_same_problem_in_several_files_and_repeats_is_one_line() -> None:
    problems = [Problem(f"{n}.tdms", f"channels of repeat {r}", "ai2", "S2") for n in range(3) for r in (1, 2, 3)]
    error = CampaignFileError(Path("plate"), [*problems, Problem("2.tdms", "step", "nothing", "an integer")])
    assert str(error).splitlines() == [
        "plate: 10 problems, 2 of them different",
        "  0.tdms and 2 more files: channels of repeat 1 = ai2; allowed: S2 (also in 2 more repeats)",
        "  2.tdms: step = nothing; allowed: an integer",
    ]
    assert str(CampaignFileError(Path("plate"), problems)).startswith("plate: 0.tdms and 2 more files: channels")
    assert len(error.problems) == 10


def test_another_fault_does_not_hide_behind_many_of_one_key() -> None:
    many = [Problem(f"{n}", "level", f"{n} V", "1 V") for n in range(100)]
    assert "99: step = x" in str(CampaignFileError(Path("plate"), [*many, Problem("99", "step", "x", "y")]))


def test_the_current_folder_is_not_named_where_a_file_is() -> None:
    assert str(CampaignFileError(Path(), [Problem("nope.toml", "", "gone", "")])) == "nope.toml: gone"
    assert str(CampaignFileError(Path(), [Problem("", "", "not a campaign", "")])) == ".: not a campaign"
