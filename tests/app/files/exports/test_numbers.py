"""NPZ, CSV and WAV, read back with other means."""

import csv
import json

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.io import wavfile

from app.files.exports.written_filters import write_csv, write_npz, write_wav

AT = np.array([0.0, 12.5, 60.0])


def test_npz_gives_taps_and_what_makes_them_anywhere(tmp_path, shipments):
    shipment = shipments["network"]
    (path,) = write_npz(shipment, tmp_path, AT)
    with np.load(path, allow_pickle=False) as held:
        np.testing.assert_array_equal(held["taps"], shipment.filters.taps(AT))
        x = np.interp(33.0, held["input_temperature"], held["input_value"])
        hidden = np.append(np.tanh(x * held["slope"] + held["bias"]), np.ones((3, 1)), axis=1)
        taps = np.einsum("nk,nkm->nm", hidden, held["banks"])
        assert json.loads(str(held["provenance"]))["format"] == "flexura-filters/1"
        assert list(held["actuators"]) == ["A1", "A2", "A3"]
    np.testing.assert_allclose(taps, shipment.filters.taps(33.0)[0], atol=1e-12)
    assert path.read_bytes() == write_npz(shipment, tmp_path, AT)[0].read_bytes()


def test_npz_of_a_spline_is_that_spline(tmp_path, shipments):
    (path,) = write_npz(shipments["cubic-spline"], tmp_path, AT)
    with np.load(path, allow_pickle=False) as held:
        spline = CubicSpline(held["knots"], held["banks"].transpose(1, 0, 2))
        np.testing.assert_allclose(spline(AT), held["taps"], atol=1e-12)


def test_csv_says_where_it_comes_from_and_holds_every_tap(tmp_path, shipments):
    (path,) = write_csv(shipments["linear"], tmp_path, AT)
    lines = path.read_text(encoding="utf-8").splitlines()
    assert json.loads(lines[0].removeprefix("# "))["format"] == "flexura-filters/1"
    rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    found = np.array([[float(row[name]) for name in ("A1", "A2", "A3")] for row in rows]).reshape(3, 50, 3)
    np.testing.assert_allclose(
        found.transpose(0, 2, 1), shipments["linear"].filters.taps(AT), rtol=1e-8, atol=1e-12
    )
    assert [row["temperature_c"] for row in rows[::50]] == ["0", "12.5", "60"]


def test_wav_holds_one_response_a_channel_and_one_temperature_a_file(tmp_path, shipments):
    paths = write_wav(shipments["network"], tmp_path, AT)
    assert [path.name for path in paths] == [
        f"flexura_filters_{t}C.wav" for t in ("+000.00", "+012.50", "+060.00")
    ]
    for path, taps in zip(paths, shipments["network"].filters.taps(AT), strict=True):
        rate, found = wavfile.read(path)
        assert rate == 8_000
        np.testing.assert_allclose(found.T, taps, rtol=1e-6)


def test_a_folder_that_cannot_be_written_leaves_nothing(tmp_path, shipments):
    from app.files.bad_file import ResultFileError

    (tmp_path / "taken").write_text("a file")
    with pytest.raises(ResultFileError, match="cannot be written"):
        write_wav(shipments["network"], tmp_path / "taken", AT)
    assert [path.name for path in tmp_path.iterdir()] == ["taken"]
