"""Modal tests in a script: as the verb, with FRFs as values that may be changed in between."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import flexura
from app.files.bad_file import ResultFileError
from app.modal_test.modes_of_test import load_test
from tests.app.modal_test.conftest import ETA, Beam, F, hammer_files


@pytest.fixture(scope="module")
def declared(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return hammer_files(tmp_path_factory.mktemp("beam"), Beam())


def test_a_test_is_identified_as_by_the_verb(declared: Path, tmp_path: Path) -> None:
    found = flexura.identify_test(declared, band=(40.0, 700.0), out=tmp_path / "run", progress=False)
    read = found.modes.reading("viscous")
    real = found.shapes.pole
    np.testing.assert_allclose(read.frequency_hz[real], F, rtol=1e-3)
    np.testing.assert_allclose(2.0 * read.damping_ratio[real], ETA, rtol=0.03)
    _, modes, shapes = load_test(tmp_path / "run")
    np.testing.assert_array_equal(modes.poles, found.modes.poles)
    np.testing.assert_array_equal(shapes.shape, found.shapes.shape)
    report = flexura.report(tmp_path / "run", progress=False)
    assert report.target == tmp_path / "run" / "report.html"
    assert report.target.stat().st_size == report.size
    assert repr(report).startswith(f"<WrittenReport: report of {len(report.figures)} figures, ")


def test_frfs_are_values_that_may_be_changed(declared: Path) -> None:
    frfs = flexura.frfs_of_test(declared, progress=False)
    assert "\n" not in repr(frfs)
    assert " FRFs, " in repr(frfs)
    whole = flexura.identify_test(frfs, band=(40.0, 700.0), progress=False)
    twice = replace(frfs, transfers=tuple(replace(one, h=2.0 * one.h, variance=None) for one in frfs.transfers))
    again = flexura.identify_test(twice, band=(40.0, 700.0), progress=False)
    np.testing.assert_allclose(
        again.modes.poles[again.shapes.pole], whole.modes.poles[whole.shapes.pole], rtol=1e-4
    )
    alone = flexura.identify_test(list(frfs.transfers[:2]), band=(40.0, 700.0), progress=False)
    assert len(alone.frfs.transfers) == 2


def test_frfs_have_named_axes_and_units(declared: Path) -> None:
    pytest.importorskip("xarray")
    frfs = flexura.frfs_of_test(declared, progress=False)
    made = frfs.to_xarray()
    assert made.h.dims == ("transfer", "frequency")
    np.testing.assert_array_equal(made.h.values, frfs.h)
    assert made.h.attrs["units"] == "m/s2/N"
    assert made.frequency.attrs["units"] == "Hz"
    assert made.response.values.tolist() == [one.response for one in frfs.transfers]
    node = int(frfs.transfers[1].response.partition(":")[0])
    assert float(made.x[1]) == frfs.points[node][0]
    assert made.x.attrs["units"] == "m"
    first = replace(frfs.transfers[0], units=("g", "lbf"), coherence=None)
    mixed = replace(frfs, transfers=(first, *frfs.transfers[1:]), points={}, notes=("a note",))
    other = mixed.to_xarray()
    assert other.h.attrs["units"] == "g/lbf or m/s2/N"
    assert other.unit.values.tolist()[:2] == ["g/lbf", "m/s2/N"]
    assert np.isnan(other.coherence.values[0]).all()
    assert np.isnan(other.x.values).all()
    assert other.attrs["notes"] == "a note"
    table = mixed.to_pandas()
    assert len(table) == frfs.h.size


def test_it_prints_in_a_line_and_as_a_table(declared: Path) -> None:
    pytest.importorskip("pandas")
    found = flexura.identify_test(declared, band=(40.0, 700.0), progress=False)
    assert repr(found).startswith("<TestModes: 5 FRFs, 3 modes (3 confirmed) at 5 places, misfit ")
    assert "<table>" in found._repr_html_()
    table = found.to_pandas()
    assert len(table) == 3 * 5
    assert sorted(table["frequency"].unique().round(0)) == [95.0, 262.0, 513.0]


def test_what_is_no_test_is_said(declared: Path, tmp_path: Path) -> None:
    frfs = flexura.frfs_of_test(declared, progress=False)
    shorter = replace(
        frfs.transfers[0],
        frequency=frfs.transfers[0].frequency[:-1],
        h=frfs.transfers[0].h[:-1],
        variance=None,
        coherence=None,
    )
    with pytest.raises(ValueError, match="2 FRFs over 2 different sets of lines"):
        flexura.identify_test([shorter, frfs.transfers[1]])
    with pytest.raises(ValueError, match="damping 'critical'"):
        flexura.identify_test(frfs, damping="critical")  # type: ignore[arg-type]
    with pytest.raises(ResultFileError, match="make it with"):
        flexura.report(tmp_path)
