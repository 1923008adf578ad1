"""WAV files of floats, read by two other programs."""

import numpy as np
import pytest
from scipy.io import wavfile

from app.files.bad_file import ResultFileError
from app.files.sound_file import WavFileError, create_wav, opened_sound


@pytest.mark.parametrize("channels", [1, 2, 6])
@pytest.mark.parametrize("comment", ["odd", "even"])
def test_what_was_written_is_read_back(tmp_path, channels, comment):
    soundfile = pytest.importorskip("soundfile")
    samples = (40.0 * np.random.default_rng(0).standard_normal((channels, 1001))).astype(np.float32)
    path = tmp_path / "a.wav"
    with create_wav(path, 44_100.0, channels, 1001, comment) as file:
        file.write(samples[:, :1000])
        file.write(samples[:, 1000:])
    rate, by_scipy = wavfile.read(path)
    np.testing.assert_array_equal(by_scipy.reshape(1001, channels).T, samples)
    with soundfile.SoundFile(path) as read:
        assert (read.samplerate, rate, read.comment, read.subtype) == (44_100, 44_100, comment, "FLOAT")
        np.testing.assert_array_equal(read.read(dtype="float32", always_2d=True).T, samples)


def test_what_does_not_fit_is_refused_before_a_file_is_begun(tmp_path):
    path = tmp_path / "a.wav"
    with pytest.raises(WavFileError, match="100 minutes of 6 channels; a WAV file holds 68 of them"):
        create_wav(path, 44_100.0, 6, 44_100 * 6_000, "").__enter__()
    with pytest.raises(WavFileError, match="whole numbers of Hz"):
        create_wav(path, 44_100.5, 6, 10, "").__enter__()
    assert not path.exists()


def test_a_wrong_count_is_an_error(tmp_path):
    with (
        pytest.raises(ValueError, match="9 samples written of 10"),
        create_wav(tmp_path / "a", 8e3, 2, 10, "") as file,
    ):
        file.write(np.zeros((2, 9)))
    with pytest.raises(ValueError, match="for 2 channels"), create_wav(tmp_path / "a", 8e3, 2, 10, "") as file:
        file.write(np.zeros((3, 10)))


def test_a_copy_cut_short_is_refused(tmp_path):
    """The library gives what there is: half a song was rendered without a word."""
    pytest.importorskip("soundfile")
    path = tmp_path / "a.wav"
    wavfile.write(path, 44_100, np.ones(2000, np.int16))
    with opened_sound(path) as sound:
        assert sound.frames == 2000
    path.write_bytes(path.read_bytes()[:1000])
    with pytest.raises(ResultFileError, match=r"its head says 4000; cut short\?"), opened_sound(path):
        pass
