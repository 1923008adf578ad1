"""Filters as an ONNX graph: a temperature in, the taps of every actuator out.

Written with onnx's own helper: the graph is a table look-up, a layer or a piecewise cubic, and one matrix product.
torch's exporter would take a torch module made for the purpose and two more packages, and give other nodes with
every version of torch.
"""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from analysis.rendering.following import CubicWeights, FollowingBank, TanhWeights
from app.files.bad_file import ResultFileError
from app.files.exports.destination import written_together
from app.files.exports.shipment import FORMAT, Shipment

if TYPE_CHECKING:
    import onnx

NAME = "flexura_filters.onnx"
OPSET = 17
"""Operators of 2022: runtimes of these years know them."""
IR_VERSION = 8
"""Version of the file's format that came with these operators."""


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
