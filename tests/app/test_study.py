"""``flexura study`` on a panel small enough to be reduced in seconds."""

import json

import h5py
import numpy as np
import pytest

import flexura
from app.commands import study as verb
from app.files.bad_file import ResultFileError
from app.files.results.panel_files import load_studies
from app.report.studies import pictures, rows
from app.stages import study as stage
from tests.app.test_focus_compensate import flex, laws, panel, run, write_laws  # noqa: F401


def test_one_figure_is_made_and_its_numbers_stand_beside_the_paper(run, panel):  # noqa: F811
    result = flex("study", "4", run, "--panel", panel, "--json")
    assert result.exit_code == 0, result.output
    assert (run / "study-4.png").read_bytes().startswith(b"\x89PNG")
    found = load_studies(run / "studies.h5")
    assert found.compensation is None
    printed = json.loads(result.stdout)
    assert [row["quantity"] for row in printed] == [row.quantity for row in rows(found)]
    # In time the panel answers beyond its twin's band, too, where no error is certified: 2 to 4e-3 of a panel so
    # small, whichever functions its twin has. tests/app/test_section_2_filters.py asks 1e-3 of the shipped one.
    np.testing.assert_allclose(found.played.total, found.played.expected, atol=5e-3)
    with h5py.File(run / "studies.h5") as file:
        assert [name for name in file if name != "provenance"] == ["played"]


def test_the_library_makes_the_same_figure_as_the_verb(run, panel, tmp_path):  # noqa: F811
    assert flex("study", "4", run, "--panel", panel).exit_code == 0
    found = flexura.study(4, run, panel=panel, out=tmp_path / "out")
    assert repr(found).splitlines()[0].startswith(f"<StudiedPanel: {tmp_path / 'out'}")
    said = load_studies(run / "studies.h5")
    np.testing.assert_array_equal(found.studies.played.total, said.played.total)
    assert found.file == tmp_path / "out" / "studies.h5"
    assert flexura.plot(found, "study-4").axes
    with pytest.raises(ValueError, match=r"'study-18' was not computed; these were: study-4"):
        flexura.plot(found, "study-18")


def test_what_the_verb_offers_is_what_the_stage_makes():
    assert verb.FIGURES == stage.FIGURES
    for wrong, said in (
        ({"figure": "12"}, "figure 12: allowed are 4, 13"),
        ({"figure": "4", "seed": -1}, "--seed -1"),
        ({"figure": "4", "as_paper": True, "changes": {"design": "inverse-fft"}}, "sets --design itself"),
    ):
        with pytest.raises(ResultFileError, match=said):
            stage.StudyRequest(**wrong)


@pytest.mark.slow
def test_all_figures_are_made_as_in_the_paper(run, panel):  # noqa: F811
    result = flex("study", "all", run, "--panel", panel, "--as-paper")
    assert result.exit_code in (0, 1), result.output
    if result.exit_code == 0:
        found = load_studies(run / "studies.h5")
        settings = found.compensation.trained.settings
        assert (settings.feed, settings.scale, settings.start, settings.split) == (
            "temperature",
            "tap",
            "random",
            "matlab",
        )
        assert [one.name for one in pictures(found)] == [f"study-{n}" for n in (4, 13, 14, 15, 16, 17, 18, 19)]


def test_a_figure_the_paper_does_not_have_is_refused(run):  # noqa: F811
    result = flex("study", "12", run)
    assert result.exit_code == 2
    assert not (run / "studies.h5").exists()


@pytest.mark.parametrize(("figure", "hottest", "spacing"), [("15", 28.0, 5), ("19", 32.0, 8), ("all", 32.0, 8)])
def test_laws_of_too_few_degrees_to_train_on_are_refused_in_a_sentence(
    tmp_path,
    panel,  # noqa: F811
    figure,
    hottest,
    spacing,
):
    narrow = write_laws(tmp_path / "narrow", laws(20.0, hottest))
    result = flex("study", figure, narrow, "--panel", panel)
    assert result.exit_code == 1
    assert (
        f"20 to {hottest:g} °C give too few temperatures {spacing} °C apart to train networks on" in result.output
    )
    assert "Traceback" not in result.output
    assert [path.name for path in narrow.iterdir()] == ["laws.h5"]
