"""Filters as C99: a header and one file, nothing allocated, in float32 or int16.

Bytes and multiplications that filters cost on the target.
"""

import hashlib
from collections.abc import Iterable
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from analysis.rendering.following import (
    FADE_TIME,
    TEMPERATURE_STEP,
    FixedPoint,
    FollowingBank,
    TanhWeights,
    TiltBank,
)
from analysis.weather.family import plane_weights
from app.files.atomic import written_together
from app.files.exports.shipment import Shipment

SAMPLES_AT_ONCE = 256
"""Samples filtered at a time; longer blocks are cut, shorter ones taken as they are."""
PREFIX = "flexura"
"""Of every name that other code can see, unless another is given: two panels in one program need two."""
PREFIXES = r"[a-z][a-z0-9_]{0,30}"
"""What can be one."""
EXAMPLE = ("target.h", "target.c", "loopback.c")
"""Buffers of a serial audio port that is fed by DMA, and a program that compares them with a rendered file."""
LINE_WIDTH = 118
"""Characters of a line of numbers, so that the code can be read and compared in editors."""


def write_c(
    shipment: Shipment,
    folder: Path,
    fixed_point: bool,
    prefix: str = PREFIX,
    example: bool = False,
    tilt: bool = False,
) -> tuple[Path, ...]:
    """Write ``flexura_filters.h`` and ``flexura_filters.c``, or the same with another prefix.

    Parameters
    ----------
    fixed_point : bool
        int16 in place of float32.
    prefix : str
        Small letters, digits and underscores.
    example : bool
        Write `EXAMPLE` as well, which needs int16.
    tilt : bool
        Write the filters of the tilt, too; the shipment must have them.

    Returns
    -------
    tuple of Path

    Raises
    ------
    ValueError
        For numbers that float32 does not hold.
    ResultFileError
        Where the folder cannot be written.
    """
    header, code = c_texts(shipment, fixed_point, prefix, tilt)
    texts = {f"{prefix}_filters.h": header, f"{prefix}_filters.c": code}
    template = files("app.files.exports")
    for name in EXAMPLE if example else ():
        text = template.joinpath(f"{name}.in").read_text(encoding="ascii")
        texts[f"{prefix}_{name}"] = _named(text, prefix)
    names = tuple(texts)
    with written_together(folder, names) as paths:
        for path, text in zip(paths, texts.values(), strict=True):
            path.write_text(text, encoding="ascii", newline="\n")
    return tuple(folder / name for name in names)


def c_texts(shipment: Shipment, fixed_point: bool, prefix: str = PREFIX, tilt: bool = False) -> tuple[str, str]:
    """Return header and code.

    Parameters
    ----------
    fixed_point : bool
        int16 in place of float32.
    prefix, tilt
        As of `write_c`.

    Returns
    -------
    header, code : str
        ASCII.
    """
    filters = shipment.filters
    tilted = TiltBank.of(shipment.in_weather()[0]) if tilt else None
    short = FixedPoint.of(filters, tilted) if fixed_point else None
    arrays = "".join(_data(shipment, short))
    if tilted is not None:
        arrays += "".join(_tilt_data(shipment, tilted, short))
    data = _text("flexura_provenance", shipment.stamp) + arrays
    # Compared by the compiler, so that a header and a file of two exports do not make one program.
    digest = f"0x{hashlib.sha256(data.encode()).hexdigest()[:8]}UL"
    found = _sizes(shipment, short, tilted, digest)
    sizes = "".join(f"#define FLEXURA_{name} {value}\n" for name, value in found.items())
    template = files("app.files.exports")
    header = template.joinpath("filters.h.in").read_text(encoding="ascii").replace("@SIZES@\n", sizes)
    code = template.joinpath("filters.c.in").read_text(encoding="ascii").replace("@EXPORT@", digest)
    stamp = _text(f"{prefix}_provenance", shipment.stamp)  # its words are no names
    if tilt:
        _, judged = shipment.in_weather()
        names = "\n".join(one.encode("ascii", "replace").decode("ascii") for one in judged.names)
        stamp += _text(f"{prefix}_thermometer_names", names)
    return _named(header, prefix), _named(code, prefix).replace("@DATA@\n", stamp + _named(arrays, prefix))


def _named(text: str, prefix: str) -> str:
    """Give all names that other code can see their prefix."""
    return text.replace(f"{PREFIX}_", f"{prefix}_").replace(f"{PREFIX.upper()}_", f"{prefix.upper()}_")


def _sizes(shipment: Shipment, short: FixedPoint | None, tilted: TiltBank | None, digest: str) -> dict[str, str]:
    filters = shipment.filters
    actuators, weights, taps = filters.banks.shape
    coldest, hottest = filters.input.temperature_range
    network = isinstance(filters.weights, TanhWeights)
    sizes = {
        "EXPORT": digest,
        "FIXED_POINT": str(int(short is not None)),
        "NETWORK": str(int(network)),
        "TILT": str(int(tilted is not None)),
        "ACTUATORS": str(actuators),
        "WEIGHTS": str(weights),
        "TAPS": str(taps),
        "TABLE": str(len(filters.input.temperature)),
        "BLOCK": str(SAMPLES_AT_ONCE),
        "FADE": str(round(FADE_TIME * filters.sample_rate)),
        "DELAY": str(filters.delay),
        "SAMPLE_RATE": _number(filters.sample_rate),
        "STEP": _number(TEMPERATURE_STEP),
        "COLDEST": _number(coldest),
        "HOTTEST": _number(hottest),
    }
    if not isinstance(filters.weights, TanhWeights):
        sizes["KNOTS"] = str(len(filters.weights.knots))
    if tilted is not None:
        sizes["THERMOMETERS"] = str(len(shipment.in_weather()[1].names))
        sizes["TILT_KNOTS"] = str(len(tilted.weights.knots))
        sizes["LARGEST_TILT"] = _number(tilted.across)
    if short is not None:
        sizes["DIVISOR"] = f"((int64_t)1 << {short.shift})"
        sizes["VOLTS_PER_COUNT"] = _number(short.volts_per_count)
    return sizes


def _data(shipment: Shipment, short: FixedPoint | None) -> Iterable[str]:
    filters = shipment.filters
    yield _array("float", "table_temperature", filters.input.temperature, "TABLE")
    yield _array("float", "table_value", filters.input.value, "TABLE")
    if isinstance(filters.weights, TanhWeights):
        yield _array("float", "slope", filters.weights.slope, "ACTUATORS", "WEIGHTS - 1")
        yield _array("float", "bias", filters.weights.bias, "ACTUATORS", "WEIGHTS - 1")
    else:
        yield _array("float", "knot", filters.weights.knots, "KNOTS")
        pieces = filters.weights.coefficients
        yield f"static const float cubic[{len(pieces)}][4][FLEXURA_WEIGHTS] = {_braces(pieces)};\n\n"
    if short is None:
        yield _array("float", "bank", filters.banks, "ACTUATORS", "WEIGHTS", "TAPS")
    else:
        yield _array("float", "bank_scale", short.bank_scale / short.tap_scale, "ACTUATORS", "WEIGHTS")
        yield _array("int16_t", "bank", short.banks, "ACTUATORS", "WEIGHTS", "TAPS")


def _tilt_data(shipment: Shipment, tilted: TiltBank, short: FixedPoint | None) -> Iterable[str]:
    _, judged = shipment.in_weather()
    yield _array("float", "plane_weight[3]", plane_weights(judged.places), "THERMOMETERS")
    yield _array("float", "tilt_knot", tilted.weights.knots, "TILT_KNOTS")
    pieces = tilted.weights.coefficients
    yield _array("float", f"tilt_cubic[{len(pieces)}][4]", pieces, "TILT_KNOTS")
    if short is None or short.tilt_banks is None or short.tilt_scale is None:
        yield _array("float", "tilt_bank[FLEXURA_ACTUATORS][4]", tilted.banks, "TILT_KNOTS", "TAPS")
    else:
        scale = short.tilt_scale / short.tap_scale
        yield _array("float", "tilt_scale[FLEXURA_ACTUATORS][4]", scale, "TILT_KNOTS")
        yield _array("int16_t", "tilt_bank[FLEXURA_ACTUATORS][4]", short.tilt_banks, "TILT_KNOTS", "TAPS")


def _array(kind: str, name: str, values: ArrayLike, *sizes: str) -> str:
    shape = "".join(f"[FLEXURA_{size}]" for size in sizes)
    return f"static const {kind} {name}{shape} = {_braces(np.asarray(values))};\n\n"


def _braces(values: NDArray[np.generic]) -> str:
    if values.ndim > 1:
        return "{\n" + ",\n".join(_braces(row) for row in values) + "}"
    lines, line = [], ""
    for word in (_number(float(v)) if values.dtype.kind == "f" else str(int(v)) for v in values):
        if len(line) + len(word) + 2 > LINE_WIDTH:
            lines.append(line)
            line = ""
        line += f"{', ' if line else ''}{word}"
    return "{" + ",\n".join([*lines, line]) + "}"


def _number(value: float) -> str:
    """Write a constant of type float, to the last bit."""
    single = np.float32(value)
    if not np.isfinite(single):
        raise ValueError(f"{value:g} is too large for float32")
    text = f"{single:.9g}"
    return text + ("f" if set(".e") & set(text) else ".0f")


def _text(name: str, text: str) -> str:
    """Write a text as a constant; question marks escaped, because of the trigraphs of C99."""
    escaped = [{"\n": "\\n", "\\": "\\\\", '"': '\\"', "?": "\\?"}.get(letter, letter) for letter in text]
    lines = ["".join(escaped[start : start + 100]) for start in range(0, len(escaped), 100)]
    return f"const char {name}[] =\n" + "\n".join(f'    "{line}"' for line in lines) + ";\n\n"


@dataclass(frozen=True)
class Cost:
    """What the C code takes.

    Attributes
    ----------
    constant_bytes : int
        Banks and tables, in read-only memory.
    state_bytes : int
        Two sets of taps and the past of the input, in memory.
    update_operations : int
        Multiply-adds of one change of temperature.
    sample_operations : int
        Multiply-adds of one sample of audio for all actuators; twice as many during a fade.
    """

    constant_bytes: int
    state_bytes: int
    update_operations: int
    sample_operations: int

    @classmethod
    def of(
        cls,
        filters: FollowingBank,
        fixed_point: bool,
        block: int,
        tilt: TiltBank | None = None,
        thermometers: int = 0,
    ) -> Self:
        """Count for float32 or, fixed point, int16.

        Parameters
        ----------
        block : int
            Samples filtered at a time.
        tilt : TiltBank, optional
            Filters of the tilt, with the number of `thermometers` that tell it.
        """
        actuators, weights, taps = filters.banks.shape
        size = 2 if fixed_point else 4
        tables = 8 * len(filters.input.temperature) + (4 * actuators * weights if fixed_point else 0)
        if isinstance(filters.weights, TanhWeights):
            tables += 8 * filters.weights.slope.size
            per_update = filters.weights.slope.size
        else:
            tables += 4 * (filters.weights.coefficients.size + len(filters.weights.knots))
            per_update = 3 * weights
        banks, state = filters.banks.size, 12
        if tilt is not None:
            banks, state = banks + tilt.banks.size, state + 8
            tables += 4 * (tilt.weights.coefficients.size + len(tilt.weights.knots) + 3 * thermometers)
            tables += 4 * tilt.banks[..., 0].size if fixed_point else 0
            per_update += tilt.banks.size + 3 * thermometers + 5 * tilt.banks[..., 0].size
        return cls(
            constant_bytes=size * banks + tables,
            state_bytes=-(-size * (2 * actuators * taps + taps - 1 + block) // 4) * 4 + state,
            update_operations=actuators * weights * taps + per_update,
            sample_operations=actuators * taps,
        )
