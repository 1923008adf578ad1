"""The C code, compiled with every warning an error and both sanitizers, against the renderer in Python."""

import json
import re
import shutil
import subprocess
from dataclasses import replace

import numpy as np
import pytest
from scipy.io import wavfile

from analysis.rendering.following import FixedPoint, TiltBank
from analysis.rendering.renderer import Renderer
from analysis.weather.family import TiltFamily, plane
from analysis.weather.judged import WeatherJudgement
from app.files.exports.c_code import SAMPLES_AT_ONCE, Cost, c_texts, write_c

GCC = shutil.which("gcc")
THERMOMETERS = np.array([[-0.9, 0.1], [0.8, -0.7], [0.7, 0.9], [0.0, 0.0]])
SANITIZED = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
STRICT = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-O1", "-g"]
KINDS = ("network", "cubic-spline", "cubic-spline-rigidity", "linear", "single")
MAIN = r"""
#include "flexura_filters.h"
#include <stdio.h>
static flexura_filters filters;
static flexura_tap taps[FLEXURA_ACTUATORS][FLEXURA_TAPS];
static flexura_sample in[%(piece)d], result[FLEXURA_ACTUATORS][%(piece)d];
int main(void)
{
    flexura_sample *out[FLEXURA_ACTUATORS];
    float temperature;
    int n, changes = 0, first = 1;
    fprintf(stderr, "{\"state\": %%d, \"provenance\": %%s,", (int)sizeof filters, flexura_provenance);
    for (n = 0; n < FLEXURA_ACTUATORS; n++)
        out[n] = result[n];
    while (fread(&temperature, sizeof temperature, 1, stdin) == 1 && fread(in, sizeof in, 1, stdin) == 1) {
        if (first)
            flexura_start(&filters, temperature);
        else
            changes += flexura_temperature(&filters, temperature);
        first = 0;
        flexura_process(&filters, in, out, %(piece)d);
        fwrite(result, sizeof result, 1, stdout);
        flexura_taps(temperature, taps);
        fwrite(taps, sizeof taps, 1, stdout);
    }
    fprintf(stderr, "\"changes\": %%d}\n", changes);
    return 0;
}
"""

pytestmark = pytest.mark.skipif(GCC is None, reason="needs gcc")


def run(folder, shipment, fixed_point, temperature, signal):
    """Output (N, samples), taps (pieces, N, M) and what the program says, for a temperature a piece of signal."""
    folder.mkdir(exist_ok=True)
    write_c(shipment, folder, fixed_point)
    piece = len(signal) // len(temperature)
    (folder / "main.c").write_text(MAIN % {"piece": piece})
    sources = [folder / "main.c", folder / "flexura_filters.c"]
    command = [GCC, *STRICT, *SANITIZED, "-o", folder / "program", *sources, "-lm"]
    subprocess.run([str(word) for word in command], check=True)
    kind = np.int16 if fixed_point else np.float32
    told = b"".join(
        np.float32(t).tobytes() + part.astype(kind).tobytes()
        for t, part in zip(temperature, signal.reshape(len(temperature), -1), strict=True)
    )
    done = subprocess.run([folder / "program"], input=told, capture_output=True, check=True)
    actuators, _, taps = shipment.filters.banks.shape
    rows = np.frombuffer(done.stdout, kind).reshape(len(temperature), actuators * (piece + taps))
    out = rows[:, : actuators * piece].reshape(-1, actuators, piece).transpose(1, 0, 2).reshape(actuators, -1)
    return out.astype(float), rows[:, actuators * piece :].reshape(-1, actuators, taps), json.loads(done.stderr)


def ride(piece):
    """Temperatures that stand, creep, jump, leave the range and fail; noise beside them."""
    temperature = np.array(
        [20.0, 20.2, 20.3, 25.0, 33.0, 33.0, 33.1, 61.0, 70.0, np.nan, -20.0, -20.0, 59.9, 59.8]
    )
    rng = np.random.default_rng(3)
    return temperature, np.clip(0.3 * rng.standard_normal(len(temperature) * piece), -1.0, 32_767 / 32_768)


def in_python(shipment, temperature, signal):
    piece = len(signal) // len(temperature)
    renderer = Renderer(shipment.filters, float(temperature[0]), piece)
    out = []
    for t, part in zip(temperature, signal.reshape(len(temperature), -1), strict=True):
        renderer.follow(float(t))
        out.append(renderer.process(part))
    return np.hstack(out), renderer.changes


def relative_energy(found, expected):
    return np.sum((found - expected) ** 2) / np.sum(expected**2)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("piece", [100, 7 * SAMPLES_AT_ONCE + 3])
def test_float32_is_what_python_renders(tmp_path, shipments, kind, piece):
    temperature, signal = ride(piece)
    shipment = shipments[kind]
    out, taps, told = run(tmp_path, shipment, False, temperature, signal)
    expected, changes = in_python(shipment, temperature, signal)
    assert told["changes"] == changes
    assert changes > 2 or kind == "single"
    assert relative_energy(out, expected) < 1e-10
    known = np.isfinite(temperature)
    exact = shipment.filters.taps(temperature[known])
    assert relative_energy(taps[known], exact) < 1e-11


@pytest.mark.parametrize("kind", KINDS)
def test_int16_is_what_python_renders_to_its_last_bits(tmp_path, shipments, kind):
    temperature, signal = ride(300)
    shipment, short = shipments[kind], FixedPoint.of(shipments[kind].filters)
    counts = np.round(32_768.0 * signal)
    out, taps, told = run(tmp_path, shipment, True, temperature, counts)
    expected, changes = in_python(shipment, temperature, counts / 32_768.0)
    assert told["changes"] == changes
    assert relative_energy(out * short.volts_per_count, expected) < 1e-6
    known = np.isfinite(temperature)
    by_python = short.taps(shipment.filters, temperature[known])
    assert np.abs(taps[known].astype(int) - by_python).max() <= 1


def test_int16_does_not_overflow_at_the_loudest_input_there_is(tmp_path, shipments):
    shipment = shipments["cubic-spline"]
    short = FixedPoint.of(shipment.filters)
    taps = shipment.filters.taps(0.0)[0]
    worst = np.where(taps[np.abs(taps).sum(axis=1).argmax()][::-1] > 0.0, 32_767.0, -32_768.0)
    signal = np.concatenate([worst, np.clip(-worst, -32_768.0, 32_767.0)])
    out, _, _ = run(tmp_path, shipment, True, np.zeros(2), signal)
    expected, _ = in_python(shipment, np.zeros(2), signal / 32_768.0)
    assert np.abs(out).max() > 8_000
    assert relative_energy(out * short.volts_per_count, expected) < 1e-6


MAIN_OF_THERMOMETERS = r"""
#include "flexura_filters.h"
#include <stdio.h>
static flexura_filters filters;
static flexura_sample in[%(piece)d], result[FLEXURA_ACTUATORS][%(piece)d];
int main(void)
{
    flexura_sample *out[FLEXURA_ACTUATORS];
    float reading[FLEXURA_THERMOMETERS];
    int n, changes = 0;
    for (n = 0; n < FLEXURA_ACTUATORS; n++)
        out[n] = result[n];
    flexura_start(&filters, 20.0f);
    while (fread(reading, sizeof reading, 1, stdin) == 1 && fread(in, sizeof in, 1, stdin) == 1) {
        changes += flexura_thermometers(&filters, reading);
        flexura_process(&filters, in, out, %(piece)d);
        fwrite(result, sizeof result, 1, stdout);
    }
    fprintf(stderr, "{\"changes\": %%d, \"state\": %%d, \"names\": \"%%s\"}", changes, (int)sizeof filters,
            flexura_thermometer_names);
    return 0;
}
"""


@pytest.fixture(scope="module")
def tilted(shipments):
    """Return filters with some of the tilt, of a run that was judged with four thermometers."""
    rng, knots = np.random.default_rng(8), np.arange(0.0, 61.0, 15.0)
    shape = np.exp(-np.arange(50) / 12.0) * rng.standard_normal((len(knots), 2, 3, 50))
    taps = rng.standard_normal((2, len(knots), 3, 50))
    family = TiltFamily(knots, 12.0, *taps, 0.02 * shape, 2e-3 * shape[::-1], np.zeros((len(knots), 2)))
    judged = WeatherJudgement(
        ways=("one",),
        names=("left", "lower", 'upper "right"', "middle"),
        places=THERMOMETERS,
        time=np.arange(2.0),
        extent=np.ones((2, 3)),
        readings=np.ones((2, 4)),
        believed=np.ones((1, 2, 3)),
        contrast=np.ones((1, 2, 5)),
        known=np.ones((2, 5)),
        level=np.ones((1, 2, 2)),
        price=np.ones(2),
        across=12.0,
    )
    return replace(shipments["cubic-spline"], family=family, weather=judged)


@pytest.mark.parametrize("fixed_point", [False, True])
@pytest.mark.parametrize("kind", ["cubic-spline", "network", "single"])
def test_filters_of_the_tilt_are_what_python_renders(tmp_path, shipments, tilted, kind, fixed_point):
    """Planes that stand, creep, tilt only, lie beyond the largest tilt, and a thermometer that fails."""
    shipment = replace(tilted, filters=shipments[kind].filters)
    planes = [
        (20, 0, 0),
        (20, 0.3, 0.1),
        (20, 4, -3),
        (20.1, 4, -3),
        (31, 6, 5),
        (31, 30, -5),
        (np.nan, 0, 0),
        (64, -9, 2),
    ]
    piece, rng = 300, np.random.default_rng(3)
    readings = np.array(
        [[t + 0.5 * (x * gx + y * gy) for x, y in THERMOMETERS] for t, gx, gy in planes], np.float32
    )
    signal = np.clip(0.3 * rng.standard_normal((len(planes), piece)), -1.0, 32_767 / 32_768).astype(np.float32)
    kind_of, scale = (np.int16, 32_768.0) if fixed_point else (np.float32, 1.0)
    sent = np.round(scale * signal).astype(kind_of) if fixed_point else signal
    write_c(shipment, tmp_path, fixed_point, tilt=True)
    (tmp_path / "main.c").write_text(MAIN_OF_THERMOMETERS % {"piece": piece})
    command = [GCC, *STRICT, *SANITIZED, "-o", "program", "main.c", "flexura_filters.c", "-lm"]
    subprocess.run(command, cwd=tmp_path, check=True)
    told = b"".join(one.tobytes() + part.tobytes() for one, part in zip(readings, sent, strict=True))
    done = subprocess.run([tmp_path / "program"], input=told, capture_output=True, check=True)
    out = np.frombuffer(done.stdout, kind_of).reshape(len(planes), -1, piece).astype(float)
    renderer = Renderer(shipment.filters, 20.0, piece, shipment.family)
    expected = []
    for reading, part in zip(readings.astype(float), sent / scale, strict=True):
        believed = plane(THERMOMETERS, reading)
        renderer.follow(believed.middle, believed.across)
        expected.append(renderer.process(part))
    short = FixedPoint.of(shipment.filters, TiltBank.of(shipment.family))
    volts = short.volts_per_count if fixed_point else 1.0
    assert relative_energy(volts * out, np.array(expected)) < (1e-6 if fixed_point else 1e-10)
    said = json.loads(done.stderr.decode().replace("\n", "|").replace('upper "right"', "upper right"))
    assert said["changes"] == renderer.changes == 4
    assert said["names"] == "left|lower|upper right|middle"
    cost = Cost.of(shipment.filters, fixed_point, SAMPLES_AT_ONCE, TiltBank.of(shipment.family), 4)
    assert cost.state_bytes == said["state"]


def test_int16_with_a_tilt_does_not_overflow_at_the_loudest_input_there_is(tilted):
    bank = TiltBank.of(tilted.family)
    short, rng = FixedPoint.of(tilted.filters, bank), np.random.default_rng(2)
    for temperature in rng.uniform(0.0, 60.0, 40):
        across = tuple(rng.choice([-1.0, 1.0], 2) * bank.across)
        taps = tilted.filters.taps(temperature)[0] + bank.taps(float(temperature), across)
        np.testing.assert_allclose(
            bank.taps(float(temperature), across), tilted.family.tilt(float(temperature), across), atol=1e-12
        )
        assert np.abs(taps).max() / short.tap_scale <= 32_767
        assert np.abs(taps).sum(axis=1).max() <= 32_767 * short.volts_per_count


COUNTED = r"""
#include "flexura_filters.c"
#include <stdio.h>
int main(void)
{
    size_t held = sizeof table_temperature + sizeof table_value + sizeof bank;
#if FLEXURA_NETWORK
    held += sizeof slope + sizeof bias;
#else
    held += sizeof knot + sizeof cubic;
#endif
#if FLEXURA_FIXED_POINT
    held += sizeof bank_scale;
#endif
#if FLEXURA_TILT
    held += sizeof plane_weight + sizeof tilt_knot + sizeof tilt_cubic + sizeof tilt_bank;
#if FLEXURA_FIXED_POINT
    held += sizeof tilt_scale;
#endif
#endif
    printf("%d %d", (int)held, (int)sizeof(flexura_filters));
    return 0;
}
"""


@pytest.mark.parametrize("fixed_point", [False, True])
@pytest.mark.parametrize("kind", ["network", "cubic-spline", "single"])
def test_the_stated_bytes_are_the_compiler_s(tmp_path, shipments, kind, fixed_point):
    write_c(shipments[kind], tmp_path, fixed_point)
    (tmp_path / "main.c").write_text(COUNTED)
    subprocess.run([GCC, "-std=c99", "-o", "program", "main.c", "-lm"], cwd=tmp_path, check=True)
    said = subprocess.run([tmp_path / "program"], capture_output=True, text=True, check=True).stdout
    cost = Cost.of(shipments[kind].filters, fixed_point, SAMPLES_AT_ONCE)
    assert [cost.constant_bytes, cost.state_bytes] == [int(word) for word in said.split()]


@pytest.mark.parametrize("fixed_point", [False, True])
def test_the_stated_bytes_of_a_tilt_are_the_compiler_s(tmp_path, tilted, fixed_point):
    write_c(tilted, tmp_path, fixed_point, tilt=True)
    (tmp_path / "main.c").write_text(COUNTED)
    subprocess.run([GCC, "-std=c99", "-o", "program", "main.c", "-lm"], cwd=tmp_path, check=True)
    said = subprocess.run([tmp_path / "program"], capture_output=True, text=True, check=True).stdout
    cost = Cost.of(tilted.filters, fixed_point, SAMPLES_AT_ONCE, TiltBank.of(tilted.family), 4)
    assert [cost.constant_bytes, cost.state_bytes] == [int(word) for word in said.split()]


def test_the_example_compiles_with_a_tilt(tmp_path, tilted):
    written = write_c(tilted, tmp_path, True, example=True, tilt=True)
    sources = [path for path in written if path.suffix == ".c"]
    command = [GCC, *STRICT, "-o", tmp_path / "loopback", *sources, "-lm"]
    subprocess.run([str(word) for word in command], check=True)


def test_provenance_comes_back_from_the_program(tmp_path, shipments):
    _, _, told = run(tmp_path, shipments["linear"], False, np.array([20.0]), np.zeros(64))
    assert told["provenance"]["format"] == "flexura-filters/1"
    assert told["provenance"]["inputs"] == {"filters.h5": "0" * 64}
    assert told["provenance"]["settings"]["method"] == 'a "name" with \\ and ??( in it'


def test_header_and_file_of_two_exports_do_not_compile(tmp_path, shipments):
    write_c(shipments["linear"], tmp_path, False)
    (tmp_path / "flexura_filters.h").write_text(c_texts(shipments["network"], False)[0])
    command = [GCC, "-std=c99", "-c", "flexura_filters.c"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode != 0
    assert "are of two exports" in done.stderr


def test_the_same_filters_give_the_same_bytes(tmp_path, shipments):
    assert c_texts(shipments["network"], True) == c_texts(shipments["network"], True)
    write_c(shipments["network"], tmp_path, True)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["flexura_filters.c", "flexura_filters.h"]


@pytest.fixture(scope="module")
def loopback(tmp_path_factory, shipments):
    """Compile the example of int16 filters, with spare slots; return it with a function that renders a sound."""
    folder = tmp_path_factory.mktemp("loopback")
    shipment = shipments["cubic-spline"]
    written = write_c(shipment, folder, True, "flexura", example=True)
    assert [path.name for path in written[2:]] == ["flexura_target.h", "flexura_target.c", "flexura_loopback.c"]
    sources = [path for path in written if path.suffix == ".c"]
    command = [GCC, *STRICT, *SANITIZED, "-DFLEXURA_PLAYED_SLOTS=8", "-o", folder / "loopback", *sources, "-lm"]
    subprocess.run([str(word) for word in command], check=True)

    def rendered(counts, first, last):
        """Drive (N, frames + taps - 1), V, as ``flexura render`` computes it in blocks of 512."""
        renderer = Renderer(shipment.filters, first, 512)
        length = len(counts) + shipment.filters.banks.shape[2] - 1
        padded = np.zeros(-(-length // 512) * 512)
        padded[: len(counts)] = counts / 32_768.0
        out = []
        for start in range(0, len(padded), 512):
            renderer.follow(first + (last - first) * min(start / len(counts), 1.0))
            out.append(renderer.process(padded[start : start + 512]))
        return np.hstack(out)[:, :length]

    return folder / "loopback", rendered


@pytest.fixture
def rng():
    return np.random.default_rng(11)


def checked(program, folder, counts, drive, *temperatures, rate=8_000):
    wavfile.write(folder / "sound.wav", rate, counts)
    wavfile.write(folder / "rendered.wav", 8_000, drive.T.astype(np.float32))
    words = [program, folder / "sound.wav", folder / "rendered.wav", *temperatures]
    return subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False)


@pytest.mark.parametrize("channels", [1, 2])
def test_the_buffers_of_the_target_play_what_was_rendered(tmp_path, loopback, channels, rng):
    program, rendered = loopback
    counts = np.round(9_000.0 * np.clip(rng.standard_normal(20_000), -3.0, 3.0)).astype(np.int16)
    sound = np.repeat(counts[:, None], channels, axis=1) if channels > 1 else counts
    for temperatures in ((31.3, 31.3), (12.0, 48.0)):
        done = checked(program, tmp_path, sound, rendered(counts, *temperatures), *temperatures)
        assert done.returncode == 0, done.stdout + done.stderr
        said = r"channel \d: error -\d+\.\d dB of the rendered drive, 0\.\d+ counts rms\n"
        assert len(re.findall(said, done.stdout)) == 3


def test_a_quiet_sound_agrees_to_the_rounding_of_its_drive(tmp_path, loopback, rng):
    """Rounding leaves 1/sqrt(12) of a count rms, which is more than -50 dB of a drive of less than 91 counts."""
    program, rendered = loopback
    counts = np.round(400.0 * rng.standard_normal(20_000)).astype(np.int16)
    drive = rendered(counts, 20.0, 20.0)
    done = checked(program, tmp_path, counts, drive, 20.0)
    said = re.findall(r"error (-\d+\.\d) dB .*, (\d\.\d+) counts", done.stdout)
    found = [(float(decibels), float(rms)) for decibels, rms in said]
    assert done.returncode == 0, done.stdout + done.stderr
    assert all(decibels > -50.0 for decibels, _ in found)
    assert [rms for _, rms in found] == pytest.approx([12.0**-0.5] * 3, abs=0.02)
    exchanged = checked(program, tmp_path, counts, drive[[1, 0, 2]], 20.0)
    assert (exchanged.returncode, exchanged.stdout.count("NOT what was rendered")) == (1, 2)
    late = checked(program, tmp_path, counts, np.roll(drive, 1, axis=1), 20.0)
    assert late.returncode == 1


def test_of_a_sound_that_is_too_quiet_nothing_is_said(tmp_path, loopback, rng):
    program, rendered = loopback
    counts = np.round(3.0 * rng.standard_normal(20_000)).astype(np.int16)
    done = checked(program, tmp_path, counts, rendered(counts, 20.0, 20.0), 20.0)
    assert (done.returncode, done.stdout.count("too quiet to tell")) == (2, 3)
    assert "30 are needed: play a louder sound" in done.stderr


def test_the_loop_back_check_sees_what_is_wrong(tmp_path, loopback, rng):
    program, rendered = loopback
    counts = np.round(9_000.0 * np.clip(rng.standard_normal(9_000), -3.0, 3.0)).astype(np.int16)
    drive = rendered(counts, 20.0, 20.0)
    exchanged = checked(program, tmp_path, counts, drive[[1, 0, 2]], 20.0)
    assert exchanged.returncode == 1
    assert exchanged.stdout.count("NOT what was rendered") == 2
    warmer = checked(program, tmp_path, counts, drive, 24.0)
    assert warmer.returncode == 1
    late = checked(program, tmp_path, counts, np.roll(drive, 1, axis=1), 20.0)
    assert late.returncode == 1
    few = checked(program, tmp_path, counts, drive[:2], 20.0)
    assert (few.returncode, "2 channels at 8000 Hz; 3 at 8000 Hz wanted" in few.stderr) == (2, True)
    slow = checked(program, tmp_path, counts, drive, 20.0, rate=44_100)
    assert (slow.returncode, "has 44100 Hz" in slow.stderr) == (2, True)
    floats = checked(program, tmp_path, counts.astype(np.float32), drive, 20.0)
    assert (floats.returncode, "not a WAV file of 16-bit integers" in floats.stderr) == (2, True)
    cut = tmp_path / "cut.wav"
    cut.write_bytes((tmp_path / "rendered.wav").read_bytes()[:20])
    wavfile.write(tmp_path / "sound.wav", 8_000, counts)
    words = [str(word) for word in (program, tmp_path / "sound.wav", cut, 20.0)]
    assert subprocess.run(words, capture_output=True, check=False).returncode == 2


GXX = shutil.which("g++")
TWO_PANELS = r"""
#include "front_filters.h"
#include "rear_door_filters.h"
#include <cstdio>
static front_filters front;
static rear_door_filters rear;
int main()
{
    front_start(&front, 20.0f);
    rear_door_start(&rear, 20.0f);
    std::printf("%d %d\n", FRONT_ACTUATORS, REAR_DOOR_TAPS);
    return 0;
}
"""


@pytest.mark.skipif(GXX is None, reason="needs g++")
def test_two_panels_in_one_program_of_cpp(tmp_path, shipments):
    """Their names do not collide, and C++ finds functions that were compiled as C."""
    objects = []
    for prefix, kind in (("front", "linear"), ("rear_door", "network")):
        header, code = write_c(shipments[kind], tmp_path, False, prefix)
        assert (header.name, code.name) == (f"{prefix}_filters.h", f"{prefix}_filters.c")
        objects.append(code.with_suffix(".o"))
        subprocess.run([GCC, *STRICT, "-c", str(code), "-o", str(objects[-1])], check=True)
    main = tmp_path / "main.cpp"
    main.write_text(TWO_PANELS)
    command = [GXX, "-Wall", "-Wextra", "-Werror", "-o", tmp_path / "program", main, *objects, "-lm"]
    subprocess.run([str(word) for word in command], check=True)
    done = subprocess.run([str(tmp_path / "program")], capture_output=True, text=True, check=True)
    actuators, taps = shipments["linear"].filters.banks.shape[0], shipments["network"].filters.banks.shape[2]
    assert done.stdout == f"{actuators} {taps}\n"


@pytest.mark.skipif(GXX is None, reason="needs g++")
@pytest.mark.parametrize("fixed_point", [False, True])
def test_a_compiler_of_cpp_takes_the_code_as_well(tmp_path, tilted, fixed_point):
    """Some tool chains compile every file as C++, where C has words that C++ has not."""
    written = write_c(tilted, tmp_path, fixed_point, example=fixed_point, tilt=True)
    strict = ["-std=c++11", "-Wall", "-Wextra", "-Werror"]
    for source in (path for path in written if path.suffix == ".c"):
        command = [GXX, "-x", "c++", *strict, "-c", str(source), "-o", str(tmp_path / "as_cpp.o")]
        subprocess.run(command, check=True)
