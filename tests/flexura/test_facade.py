"""The library: what the functions give is what the verbs save, prints in a line, and can be drawn."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flexura
from analysis.material import Material, MaterialLaws, laws_through
from analysis.recordings.campaign import Campaign
from analysis.recordings.frf import Frf
from app.files.bad_file import ResultFileError
from app.files.results.modes_file import load_modes
from app.stages.identify import IdentifiedCampaign
from flexura.figures import FIGURES

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "pp-plate"


@pytest.fixture(scope="module")
def campaign() -> Campaign:
    return flexura.load(EXAMPLE)


@pytest.fixture(scope="module")
def frf(campaign: Campaign) -> Frf:
    return flexura.frf(campaign)


@pytest.fixture(scope="module")
def identified(campaign: Campaign, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, IdentifiedCampaign]:
    run = tmp_path_factory.mktemp("run")
    return run, flexura.identify(campaign, band=(150.0, 230.0), out=run)


def test_what_is_identified_is_what_the_run_folder_holds(identified: tuple[Path, IdentifiedCampaign]) -> None:
    run, found = identified
    saved = load_modes(run / "modes.h5")
    for ours, theirs in zip(found.tracked.modes, saved.modes, strict=True):
        np.testing.assert_array_equal(ours.poles, theirs.poles)


def test_values_print_in_a_few_lines(
    campaign: Campaign, frf: Frf, identified: tuple[Path, IdentifiedCampaign]
) -> None:
    assert repr(campaign) == "<Campaign 'pp-plate': 16 sweeps, 0.0 to 60.0 °C, sensors S1>"
    assert repr(frf) == "<Frf: 16 sweeps, 0.0 to 60.0 °C, sensors S1, 3361 lines from 100 to 1500 Hz>"
    found = identified[1]
    assert repr(found).startswith("<IdentifiedCampaign: 16 sweeps, 0.0 to 60.0 °C, ")
    page = found._repr_html_()
    modes = found.tracked.modes[0]
    assert f"{modes.reading('hysteretic').frequency_hz[modes.real.argmax()]:.3f}" in page


def test_notes_stand_below_the_line_and_are_escaped() -> None:
    from app.summaries.table import as_html, as_text

    assert as_text("Thing: 3", ["first", "second"]) == "<Thing: 3>\n  first\n  second"
    assert "<p>a &lt; b</p>" in as_html("", [], ["a < b"])


@pytest.mark.parametrize("kind", list(FIGURES[Frf]))
def test_frfs_are_drawn(frf: Frf, kind: str) -> None:
    assert flexura.plot(frf, kind, channel=0).axes


def test_campaign_and_modes_are_drawn(campaign: Campaign, identified: tuple[Path, IdentifiedCampaign]) -> None:
    assert flexura.plot(campaign).axes
    for kind in FIGURES[IdentifiedCampaign]:
        assert flexura.plot(identified[1], kind).axes


def test_what_cannot_be_drawn_is_told(frf: Frf) -> None:
    with pytest.raises(TypeError, match="int has no figures; these have: Campaign, CompensatedPanel, Fo"):
        flexura.plot(3)
    with pytest.raises(ValueError, match="Frf has no figure 'laws'; it has waterfall, noise"):
        flexura.plot(frf, "laws")
    with pytest.raises(ValueError, match="channel 1: 0 to 0 wanted"):
        flexura.plot(frf, channel=1)


def test_frfs_alone_are_no_campaign_and_the_message_says_what_is(frf: Frf) -> None:
    for stage in (flexura.identify, flexura.update, flexura.gap):
        with pytest.raises(TypeError, match=r"an Frf does not know its plate: give frf\.on\(experiment\)"):
            stage(frf)
        with pytest.raises(
            TypeError, match=r"campaign .*: allowed is .* a campaign, as flexura\.load\(folder\) gives it"
        ):
            stage([frf])


def test_frfs_go_back_into_a_stage_with_their_plate(
    campaign: Campaign, frf: Frf, identified: tuple[Path, IdentifiedCampaign]
) -> None:
    given = frf.on(campaign.experiment)
    again = flexura.frf(given)
    for name in ("temperature", "level", "frequency", "h", "variance", "coherence", "repeats_dof", "excluded"):
        np.testing.assert_array_equal(getattr(again, name), getattr(frf, name), err_msg=name)
    found = flexura.identify(given, band=(150.0, 230.0))
    for ours, theirs in zip(found.tracked.modes, identified[1].tracked.modes, strict=True):
        np.testing.assert_allclose(ours.poles, theirs.poles, rtol=1e-9)
    with pytest.raises(ValueError, match=r"FRFs of other driven by one input; the plate declares S1 driven by A1"):
        replace(frf, channels=("other",)).on(campaign.experiment)


def test_a_figure_of_the_whole_plate_takes_no_channel(campaign: Campaign) -> None:
    with pytest.raises(ValueError, match="figure 'plate' of Campaign shows no single sensor"):
        flexura.plot(campaign, channel=0)


def test_a_folder_does_in_place_of_a_campaign(frf: Frf) -> None:
    np.testing.assert_array_equal(flexura.frf(EXAMPLE).h, frf.h)


@pytest.mark.parametrize(
    ("option", "told"),
    [
        ({"method": "peaks"}, "method 'peaks': auto or peak-picking"),
        ({"damping": "viscose"}, "damping 'viscose': hysteretic or viscous"),
        ({"band": (300.0, 200.0)}, "band 300 to 200 Hz: two frequencies, ascending"),
        ({"band": (100.0, 200.0, 300.0)}, "band 100 to 200 to 300 Hz: two frequencies, ascending"),
        ({"mains": 0.0}, "mains 0 Hz: 10 to 400"),
    ],
)
def test_options_are_checked_before_anything_is_read(option: dict[str, Any], told: str) -> None:
    with pytest.raises(ValueError, match=told):
        flexura.identify("nowhere", **option)


def test_hum_of_no_frequency_is_refused(campaign: Campaign) -> None:
    with pytest.raises(ValueError, match="mains 0 Hz: 10 to 400 allowed"):
        flexura.frf(campaign, mains=0.0)


def test_what_is_no_path_is_refused_with_what_is_wanted(
    campaign: Campaign, identified: tuple[Path, IdentifiedCampaign]
) -> None:
    focus: Any = flexura.focus
    with pytest.raises(TypeError, match=r"laws <Campaign .*: allowed is a path .* what flexura.update or"):
        focus(campaign)
    report: Any = flexura.report
    with pytest.raises(
        TypeError, match=r"run of type IdentifiedCampaign: allowed is a path .*write it with out=FOLDER"
    ):
        report(identified[1])
    load: Any = flexura.load
    with pytest.raises(TypeError, match=r"campaign None: allowed is a path \(str or pathlib.Path\)"):
        load(None)


def test_an_unknown_name_is_told() -> None:
    assert set(flexura.__all__) < set(dir(flexura))
    with pytest.raises(AttributeError, match=r"no attribute 'identity'; it has compensate, .*, update"):
        flexura.identity  # noqa: B018


@pytest.fixture
def laws() -> MaterialLaws:
    temperature = np.array([0.0, 20.0, 40.0, 60.0])
    ones = np.ones(4)
    return laws_through(temperature, Material(1e9 * np.array([4.0, 3.0, 2.0, 1.5]), 0.35 * ones, 0.05 * ones))


def test_filters_of_laws_in_memory_are_not_saved(laws: MaterialLaws, tmp_path: Path) -> None:
    """A result file names the files it follows from."""
    for stage in (flexura.focus, flexura.compensate):
        with pytest.raises(ValueError, match="name the run folder that holds"):
            stage(laws, out=tmp_path)


def test_an_unknown_focusing_method_is_refused(laws: MaterialLaws) -> None:
    for stage in (flexura.focus, flexura.compensate):
        with pytest.raises(ValueError, match="method 'fast': stif or time-reversal or modal-control or none"):
            stage(laws, method="fast")


@pytest.mark.parametrize("spacing", [0.0, -5.0])
def test_training_temperatures_that_cannot_be_chosen_are_refused(laws: MaterialLaws, spacing: float) -> None:
    with pytest.raises(ValueError, match=f"spacing {spacing:g} K: allowed is 0.5 to 30 K"):
        flexura.compensate(laws, spacing=spacing)


def test_no_temperature_is_refused(laws: MaterialLaws) -> None:
    with pytest.raises(ResultFileError, match="no temperature is named"):
        flexura.focus(laws, temperature=[])
