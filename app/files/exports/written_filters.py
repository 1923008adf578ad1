"""Filters written in the form that another program takes: NPZ, CSV, WAV, C, an ONNX graph.

Forms of numbers are written here: NPZ for Python, CSV for everything else, WAV for any convolution engine.

Written with onnx's own helper: the graph is a table look-up, a layer or a piecewise cubic, and one matrix product.
torch's exporter would take a torch module made for the purpose and two more packages, and give other nodes with
every version of torch.
"""

import csv
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real
from analysis.focusing.panel_model import spaced
from analysis.rendering.following import CubicWeights, FollowingBank, TanhWeights
from app.files.atomic import written_together
from app.files.bad_file import ResultFileError
from app.files.exports.c_code import PREFIX, write_c
from app.files.exports.shipment import FORMAT, Shipment
from app.files.sound_file import WavFileError, create_wav

if TYPE_CHECKING:
    import onnx

NAME = "flexura_filters.onnx"
OPSET = 17
"""Operators of 2022: runtimes of these years know them."""
IR_VERSION = 8
"""Version of the file's format that came with these operators."""


class _Graph:
    """Nodes and constants as they are added."""

    def __init__(self) -> None:
        self.nodes: list[Any] = []
        self.constants: list[Any] = []

    def constant(self, name: str, values: NDArray[np.float64]) -> str:
        from onnx import numpy_helper

        self.constants.append(numpy_helper.from_array(values.astype(np.float32), name))
        return name

    def integers(self, name: str, values: list[int]) -> str:
        from onnx import numpy_helper

        self.constants.append(numpy_helper.from_array(np.array(values, dtype=np.int64), name))
        return name

    def add(self, operator: str, inputs: list[str], output: str, **attributes: Any) -> str:
        from onnx import helper

        self.nodes.append(helper.make_node(operator, inputs, [output], name=output, **attributes))
        return output

    def place(self, value: str, starts: NDArray[np.float64], name: str) -> str:
        """Index of the interval that `value` lies in: how many of `starts`, all but the first, it has reached."""
        self.add("GreaterOrEqual", [value, self.constant(f"{name}_starts", starts)], f"{name}_reached")
        self.add("Cast", [f"{name}_reached"], f"{name}_counted", to=7)  # int64
        axes = self.integers(f"{name}_axis", [0])
        return self.add("ReduceSum", [f"{name}_counted", axes], f"{name}_place", keepdims=1)

    def looked_up(self, filters: FollowingBank) -> str:
        """Draw the table: x (1,) at the temperature, held beyond its ends."""
        t, value = filters.input.temperature, filters.input.value
        ends = [self.constant("coldest", t[0]), self.constant("hottest", t[-1])]
        self.add("Clip", ["temperature", *ends], "inside")
        place = self.place("inside", t[1:-1], "row") if len(t) > 2 else self.integers("row_place", [0])
        self.add("Gather", [self.constant("table_start", t[:-1]), place], "row_start")
        self.add("Gather", [self.constant("table_value", value[:-1]), place], "row_value")
        self.add("Gather", [self.constant("table_slope", np.diff(value) / np.diff(t)), place], "row_slope")
        self.add("Sub", ["inside", "row_start"], "beyond")
        self.add("Mul", ["beyond", "row_slope"], "risen")
        return self.add("Add", ["row_value", "risen"], "x")

    def hidden(self, weights: TanhWeights, x: str) -> str:
        """Draw the hidden layer: weights (N, 1, K)."""
        actuators = len(weights.slope)
        self.add("Mul", [self.constant("slope", weights.slope[:, None]), x], "leaning")
        self.add("Add", ["leaning", self.constant("bias", weights.bias[:, None])], "bent")
        self.add("Tanh", ["bent"], "nodes")
        return self.add("Concat", ["nodes", self.constant("one", np.ones((actuators, 1, 1)))], "weights", axis=2)

    def cubic(self, weights: CubicWeights, x: str) -> str:
        """Draw the cubics: weights (1, 1, K), the same for every actuator."""
        knots = weights.knots
        self.add("Clip", [x, self.constant("first", knots[0]), self.constant("last", knots[-1])], "within")
        place = self.place("within", knots[1:-1], "piece") if len(knots) > 2 else self.integers("piece_place", [0])
        starts = knots[: len(weights.coefficients)]
        self.add("Gather", [self.constant("knots", starts), place], "knot")
        self.add("Sub", ["within", "knot"], "s")
        last = ""
        for power in (3, 2, 1, 0):
            row = self.constant(f"cubic_{power}", weights.coefficients[:, None, power])
            self.add("Gather", [row, place], f"c_{power}")  # (1, 1, K)
            if last:
                self.add("Mul", [last, "s"], f"to_{power}")
                last = self.add("Add", [f"to_{power}", f"c_{power}"], f"up_to_{power}")
            else:
                last = f"c_{power}"
        return last


def export_temperatures(sent: Shipment, given: Sequence[float], name: str) -> Real:
    """Return the temperatures given, each once, ascending, or every 5 °C.

    Parameters
    ----------
    name : str
        What a message calls them.

    Raises
    ------
    ResultFileError
        For one that the filters do not cover.
    """
    low, high = sent.filters.temperature_range
    for t in given:
        if not low - 1e-9 <= t <= high + 1e-9:
            raise ResultFileError(f"{name} {t:g} °C is outside what the filters cover, {low:g} to {high:g} °C")
    if len(given):
        return np.array(sorted(set(given)))
    return spaced(low, high, 5.0) if low < high else np.array([low])


def same_names(temperature: Real) -> bool:
    """Whether two temperatures would give one name of a WAV file."""
    return len({f"{t:.2f}" for t in temperature}) < len(temperature)


NPZ_NAME, CSV_NAME = "flexura_filters.npz", "flexura_filters.csv"


def write_npz(shipment: Shipment, folder: Path, temperature: NDArray[np.float64]) -> tuple[Path, ...]:
    """Write ``flexura_filters.npz``: taps at some temperatures, and all that gives them at any other.

    Parameters
    ----------
    temperature : (T,) ndarray
        Of the taps (T, N, M), degrees Celsius.

    Returns
    -------
    (1,) tuple of Path

    Raises
    ------
    ResultFileError
        Where the folder cannot be written.
    """
    filters = shipment.filters
    held: dict[str, Any] = {
        "provenance": shipment.stamp,
        "actuators": shipment.names,
        "sample_rate": filters.sample_rate,
        "delay": filters.delay,
        "temperature": temperature,
        "taps": filters.taps(temperature),
        "input_temperature": filters.input.temperature,
        "input_value": filters.input.value,
        "banks": filters.banks,
    }
    if isinstance(filters.weights, TanhWeights):
        held |= {"slope": filters.weights.slope, "bias": filters.weights.bias}
    else:
        held |= {"knots": filters.weights.knots, "cubics": filters.weights.coefficients}
    with written_together(folder, (NPZ_NAME,)) as (path,), path.open("wb") as file:
        np.savez(file, **held)
    return (folder / NPZ_NAME,)


def write_csv(shipment: Shipment, folder: Path, temperature: NDArray[np.float64]) -> tuple[Path, ...]:
    """Write ``flexura_filters.csv``: one row per temperature and tap, one column per actuator.

    Taps are in V per unit of audio signal.

    Parameters
    ----------
    temperature : (T,) ndarray
        Degrees Celsius.

    Returns
    -------
    (1,) tuple of Path

    Raises
    ------
    ResultFileError
        Where the folder cannot be written.
    """
    filters = shipment.filters
    with written_together(folder, (CSV_NAME,)) as (path,), path.open("w", encoding="utf-8", newline="") as file:
        file.write(f"# {shipment.stamp}\n")
        file.write(f"# sample rate {filters.sample_rate:g} Hz, modelling delay {filters.delay} samples\n")
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(["temperature_c", "tap", *shipment.names])
        for t, taps in zip(temperature, filters.taps(temperature), strict=True):
            rows.writerows([f"{t:g}", m, *(f"{v:.9g}" for v in tap)] for m, tap in enumerate(taps.T))
    return (folder / CSV_NAME,)


def write_wav(shipment: Shipment, folder: Path, temperature: NDArray[np.float64]) -> tuple[Path, ...]:
    """Write a file per temperature, one channel per actuator, float32 in V per unit of audio signal.

    Parameters
    ----------
    temperature : (T,) ndarray
        Degrees Celsius.

    Returns
    -------
    (T,) tuple of Path

    Raises
    ------
    ResultFileError
        For a sample rate that WAV does not hold, or a folder that cannot be written.
    """
    names = tuple(f"flexura_filters_{t:+07.2f}C.wav" for t in temperature)
    filters = shipment.filters
    taps = filters.taps(temperature)
    try:
        with written_together(folder, names) as paths:
            for path, one in zip(paths, taps, strict=True):
                with create_wav(path, filters.sample_rate, len(one), one.shape[1], shipment.stamp) as file:
                    file.write(one)
    except WavFileError as error:
        raise ResultFileError(f"{error}; take --to npz") from error
    return tuple(folder / name for name in names)


def write_filters(
    sent: Shipment,
    form: str,
    folder: Path,
    temperature: Real,
    *,
    number: str,
    prefix: str | None = None,
    example: bool = False,
    tilt: bool = False,
) -> tuple[Path, ...]:
    """Write filters as ``c``, ``onnx``, ``npz``, ``wav`` or ``csv``; return the files written.

    Parameters
    ----------
    temperature : (T,) ndarray
        Degrees Celsius, for ``npz``, ``wav`` and ``csv``.
    number, prefix, example, tilt
        Of the C code, see `app.files.exports.c_code.write_c`.
    """
    if form == "c":
        return write_c(sent, folder, number == "int16", prefix or PREFIX, example, tilt)
    if form == "onnx":
        return write_onnx(sent, folder)
    return {"npz": write_npz, "wav": write_wav, "csv": write_csv}[form](sent, folder, temperature)


def write_onnx(shipment: Shipment, folder: Path) -> tuple[Path, ...]:
    """Write ``flexura_filters.onnx``.

    Returns
    -------
    (1,) tuple of Path

    Raises
    ------
    ResultFileError
        Where onnx is not installed, or the folder cannot be written.
    """
    model = graph_of(shipment)
    with written_together(folder, (NAME,)) as (path,):
        path.write_bytes(model.SerializeToString(deterministic=True))
    return (folder / NAME,)


def graph_of(shipment: Shipment) -> "onnx.ModelProto":
    """Return the model: input ``temperature`` (1,), °C, output ``taps`` (N, M), V per unit of audio signal.

    Returns
    -------
    onnx.ModelProto
        Checked.

    Raises
    ------
    ResultFileError
        Where onnx is not installed.
    """
    try:
        from onnx import TensorProto, checker, helper
    except ImportError as error:
        raise ResultFileError("--to onnx needs the package onnx: pip install 'flexura[onnx]'") from error
    filters = shipment.filters
    actuators, _, taps = filters.banks.shape
    drawn = _Graph()
    x = drawn.looked_up(filters)
    if isinstance(filters.weights, TanhWeights):
        weights = drawn.hidden(filters.weights, x)
    else:
        weights = drawn.cubic(filters.weights, x)
    drawn.add("MatMul", [weights, drawn.constant("banks", filters.banks)], "summed")  # (N, 1, K) @ (N, K, M)
    drawn.add("Squeeze", ["summed", drawn.integers("middle", [1])], "taps")
    graph = helper.make_graph(
        drawn.nodes,
        "flexura_filters",
        [helper.make_tensor_value_info("temperature", TensorProto.FLOAT, [1])],
        [helper.make_tensor_value_info("taps", TensorProto.FLOAT, [actuators, taps])],
        drawn.constants,
        doc_string="temperature in degrees Celsius to taps in volts per unit of audio signal",
    )
    model = helper.make_model(
        graph, opset_imports=[helper.make_opsetid("", OPSET)], ir_version=IR_VERSION, producer_name="flexura"
    )
    facts = {
        "format": FORMAT,
        "provenance": shipment.stamp,
        "actuators": ",".join(shipment.names),
        "sample_rate": repr(filters.sample_rate),
        "delay": str(filters.delay),
    }
    helper.set_model_props(model, facts)
    checker.check_model(model, full_check=True)
    return model
