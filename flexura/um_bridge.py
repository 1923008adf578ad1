"""A twin served over UM-Bridge: samplers and optimisers in any language can ask it (PyMC, UQpy, CUQIpy).

The protocol is JSON over HTTP (Seelinger et al., UM-Bridge, J. Open Source Softw. 8, 4748, 2023). The server of
the package ``umbridge`` listens on every interface of the computer and opens shared memory by names that its
clients choose; this one answers this computer only. Clients are those of ``umbridge``.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike
from pydantic import BaseModel, Field, ValidationError

from analysis.arrays import Complex, Real
from analysis.effect_card import Values
from app.watch.server import is_loopback
from flexura.arguments import require_range
from flexura.forward_twin import MATERIAL, ForwardTwin, Material

NAME = "twin"
LARGEST_QUESTION = 64_000_000
"""Bytes of a question: a sensitivity for two million numbers."""
CLIENT_TIMEOUT = 60.0
"""Seconds after which a client that sends or takes nothing is left."""


@dataclass(frozen=True)
class TwinQuestion:
    """FRFs of a twin at fixed lines as a function of chosen parameters.

    Attributes
    ----------
    twin : ForwardTwin
    frequency : (F,) ndarray, Hz
    parameters : tuple of str
        What is asked for, in this order: of ``youngs_modulus``, ``poisson_ratio``, ``loss_factor`` and
        `ForwardTwin.parameters`.
    material : (float, float, float)
        E [Pa], nu and eta of those that are not asked for.
    effects : mapping
        Likewise values of effects and declared quantities.
    temperature : float
        Degrees Celsius.
    """

    twin: ForwardTwin
    frequency: Real
    parameters: tuple[str, ...]
    material: Material
    effects: Mapping[str, Values] = field(default_factory=dict)
    temperature: float = 25.0

    def __post_init__(self) -> None:
        allowed = (*MATERIAL, *self.twin.parameters)
        wrong = [name for name in self.parameters if name not in allowed]
        if wrong or not self.parameters or len(set(self.parameters)) < len(self.parameters):
            raise ValueError(
                f"parameters {', '.join(wrong or self.parameters)!r}: names, each once, of {', '.join(allowed)}"
            )

    @property
    def numbers(self) -> int:
        """Real numbers of an answer: real parts of all outputs and lines, then imaginary parts."""
        return 2 * len(self.twin.outputs) * len(self.frequency)

    def answer(self, values: Real) -> Real:
        """Return the FRFs, (2 K F,)."""
        material, effects = self._at(values)
        return _real(self.twin.frf(self.frequency, material, effects=effects, temperature=self.temperature))

    def jacobian(self, values: Real) -> Real:
        """Return their derivatives, (2 K F, P), per SI unit."""
        material, effects = self._at(values)
        _, slopes = self.twin.derivatives(
            self.frequency, self.parameters, material, effects=effects, temperature=self.temperature
        )
        return np.stack([_real(one) for one in slopes], axis=1)

    def _at(self, values: Real) -> tuple[Material, dict[str, dict[str, float]]]:
        material = dict(zip(MATERIAL, self.material, strict=True))
        effects = {name: dict(those) for name, those in self.effects.items()}
        for name, value in zip(self.parameters, values.tolist(), strict=True):
            if name in MATERIAL:
                material[name] = value
            else:
                effect, _, parameter = name.rpartition(".")
                effects.setdefault(effect, {})[parameter] = value
        return (material["youngs_modulus"], material["poisson_ratio"], material["loss_factor"]), effects


def _real(h: Complex) -> Real:
    return np.concatenate([h.real.ravel(), h.imag.ravel()])


def serve(
    twin: ForwardTwin,
    frequency: ArrayLike,
    parameters: Sequence[str],
    material: Material,
    *,
    effects: Mapping[str, Values] | None = None,
    temperature: float = 25.0,
    port: int = 4242,
) -> "ModelServer":
    """Open a server of the model ``twin`` at http://127.0.0.1:port; its ``serve_forever()`` serves.

    Inputs are one vector of `parameters`; outputs are one of the real parts of all FRFs (output by output), then
    the imaginary parts. Gradients and Jacobians are analytic.

    Parameters
    ----------
    frequency : (F,) array_like, Hz
    parameters : sequence of str
        As in `ForwardTwin.derivatives`.
    material : (float, float, float)
        E [Pa], nu and eta, where they are not among `parameters`.
    effects : mapping, optional
        Effects and declared quantities that are on, likewise.
    temperature : float
        Degrees Celsius.
    port : int
        0 for any free one.

    Raises
    ------
    ValueError
        For an unknown parameter, and a material or frequencies that the twin refuses.
    OSError
        Where the port is not free.
    """
    require_range("port", (port,), 0, 65_535)
    lines = np.atleast_1d(np.asarray(frequency, float))
    asked = TwinQuestion(twin, lines, tuple(parameters), material, effects or {}, temperature)
    twin.frf(lines[:1], material, effects=effects or {}, temperature=temperature)
    twin.frf(lines[-1:], material, effects=effects or {}, temperature=temperature)
    return ModelServer(asked, port)


class ModelServer(ThreadingHTTPServer):
    """Answers questions of this computer."""

    daemon_threads = True

    def __init__(self, asked: TwinQuestion, port: int) -> None:
        self.asked = asked
        super().__init__(("127.0.0.1", port), _Handler)

    def server_bind(self) -> None:
        """Bind, without asking a name server what this host is called."""
        self.socket.bind(self.server_address)
        self.server_address = self.socket.getsockname()
        self.server_name, self.server_port = str(self.server_address[0]), int(self.server_address[1])

    @property
    def url(self) -> str:
        """Address for clients."""
        return f"http://127.0.0.1:{self.server_port}"

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Say nothing of clients that went away."""


Vector = Annotated[list[float], Field(max_length=4_000_000)]


class _Asked(BaseModel):
    name: str
    config: dict[str, Any] = {}


class _Point(_Asked):
    input: Annotated[list[Vector], Field(min_length=1, max_length=1)]


class _Slope(_Point):
    outWrt: Annotated[int, Field(ge=0, le=0)]  # noqa: N815 (the protocol's names)
    inWrt: Annotated[int, Field(ge=0, le=0)]  # noqa: N815


class _Gradient(_Slope):
    sens: Vector


class _Direction(_Slope):
    vec: Vector


class _Handler(BaseHTTPRequestHandler):
    server: ModelServer
    timeout = CLIENT_TIMEOUT
    server_version, sys_version = "flexura", ""

    def log_message(self, format: str, *args: Any) -> None:
        """Write no log."""

    def do_GET(self) -> None:
        """Say which model there is."""
        if not self._is_ours():
            return
        if self.path != "/Info":
            self._fail("UnsupportedFeature", f"no page {self.path[:80]!r}", HTTPStatus.NOT_FOUND)
            return
        self._answer({"protocolVersion": 1.0, "models": [NAME]})

    def do_POST(self) -> None:
        """Answer a question about it."""
        if not self._is_ours():
            return
        length = self.headers.get("Content-Length", "")
        if not (length.isascii() and length.isdigit() and int(length) <= LARGEST_QUESTION):
            self._fail("InvalidInput", f"a body of 1 to {LARGEST_QUESTION} bytes is wanted, its length stated")
            return
        try:
            self._answer(self._answered(self.path, self.rfile.read(int(length))))
        except ValidationError as error:
            first = error.errors(include_url=False)[0]
            self._fail("InvalidInput", f"{'.'.join(map(str, first['loc']))}: {first['msg']}")
        except ValueError as error:
            self._fail("InvalidInput", str(error))

    def _answered(self, path: str, body: bytes) -> dict[str, Any]:
        asked = self.server.asked
        kinds: dict[str, type[_Asked]] = {
            "/Evaluate": _Point,
            "/Gradient": _Gradient,
            "/ApplyJacobian": _Direction,
        }
        question = kinds.get(path, _Asked).model_validate_json(body)
        if question.name != NAME:
            raise ValueError(f"model {question.name[:80]!r} is not here; allowed: {NAME}")
        if path == "/ModelInfo":
            able = {"Evaluate": True, "Gradient": True, "ApplyJacobian": True, "ApplyHessian": False}
            return {"support": able}
        if path == "/InputSizes":
            return {"inputSizes": [len(asked.parameters)]}
        if path == "/OutputSizes":
            return {"outputSizes": [asked.numbers]}
        if not isinstance(question, _Point):
            raise ValueError(f"{path[:80]!r} is not supported; allowed: Evaluate, Gradient, ApplyJacobian")
        point = _sized(question.input[0], len(asked.parameters), f"input ({', '.join(asked.parameters)})")
        if isinstance(question, _Gradient):
            sensitivity = _sized(question.sens, asked.numbers, "sens")
            return {"output": np.dot(sensitivity, asked.jacobian(point)).tolist()}
        if isinstance(question, _Direction):
            vector = _sized(question.vec, len(asked.parameters), "vec")
            return {"output": np.dot(asked.jacobian(point), vector).tolist()}
        return {"output": [asked.answer(point).tolist()]}

    def _is_ours(self) -> bool:
        """Whether the request names this computer: a page from elsewhere may have its own name point here."""
        name = self.headers.get("Host", "").rpartition(":")[0]
        if is_loopback(name):
            return True
        self._fail("InvalidInput", "this model is reached as localhost only", HTTPStatus.MISDIRECTED_REQUEST)
        return False

    def _fail(self, kind: str, message: str, status: HTTPStatus = HTTPStatus.BAD_REQUEST) -> None:
        self.close_connection = True
        self._answer({"error": {"type": kind, "message": message}}, status)

    def _answer(self, content: Mapping[str, Any], status: HTTPStatus = HTTPStatus.OK) -> None:
        body = json.dumps(content).encode()
        self.send_response(status)
        self.send_header("Content-Type", "application/json")
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)


def _sized(values: Sequence[float], count: int, what: str) -> Real:
    found = np.array(values)
    if found.size != count or not np.isfinite(found).all():
        raise ValueError(f"{what}: {count} finite numbers are wanted, {found.size} came")
    return found
