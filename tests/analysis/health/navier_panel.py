"""A simply supported plate with patches in Navier's series: a twin in closed form, with exact effects.

Modes phi = 2 sin(m pi x/a) sin(n pi y/b) over unit mass, D (1 + j eta) k**4 their stiffness. Patches bend along
both axes: their coupling to a mode is that of the curvature under them. Small enough for histories of hundreds of
weeks.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from analysis.arrays import Complex, Real
from analysis.effect_card import EffectCard, Parameter, Values
from analysis.material import LocalLaws, MaterialBox
from analysis.recordings.sweep_point import SweepPoint
from analysis.twin_model import NO_EFFECTS, Effects, Linearisation, Tangent

System = tuple[Complex, Complex, Complex, Complex]
A, B, H, DENSITY = 0.24, 0.19, 0.003, 950.0
RADIUS = 0.012
STEP = 1e-4
"""Of central differences of the matrices, which are at most quadratic in what moves."""


def places(count_x: int = 6, count_y: int = 5) -> tuple[Values, ...]:
    x, y = ((np.arange(n) + 0.5) * side / n for n, side in ((count_x, A), (count_y, B)))
    return tuple({"x": float(p), "y": float(q)} for q in y for p in x)


def _placed(name: str, amplitude: Parameter) -> EffectCard:
    coordinates = (
        Parameter("x", "m", 0.012, A - 0.012, A / 12**0.5, shape=True, typical=0.1, shown="mm"),
        Parameter("y", "m", 0.012, B - 0.012, B / 12**0.5, shape=True, typical=0.1, shown="mm"),
    )
    return EffectCard(name, name, (amplitude, *coordinates), "modes", "a look", sites=places())


CARDS: Mapping[str, EffectCard] = {
    "patch_debond": EffectCard(
        "patch_debond",
        "a patch comes off",
        tuple(Parameter(name, "1", 0.0, 0.4, 0.1, shown="%") for name in ("A1", "A2", "S1", "S2")),
        "modes",
        "a look",
    ),
    "local_damage": _placed("local_damage", Parameter("loss", "1", 0.0, 0.5, 0.2, shown="%")),
    "mass_at_place": _placed("mass_at_place", Parameter("mass", "kg", 0.0, 0.05, 0.001, shown="g")),
    "spring_at_place": _placed("spring_at_place", Parameter("stiffness", "N/m", 0.0, 5e4, 500.0)),
}


@dataclass(frozen=True)
class NavierPanel:
    """Charge of sensor patches per volt on actuator patches.

    Attributes
    ----------
    waves : int
        Half-waves along each side.
    actuators, sensors : tuple of (x, y)
        Centres of square patches, m.
    half : float
        Half of a patch's side, m.
    patch_share : float
        Stiffness that a patch adds to the plate under it, over the plate's.
    """

    waves: int = 6
    actuators: tuple[tuple[float, float], ...] = ((0.2, 0.155), (0.045, 0.12))
    sensors: tuple[tuple[float, float], ...] = ((0.04, 0.035), (0.175, 0.055))
    half: float = 0.01
    patch_share: float = 1.5
    box: MaterialBox = field(default_factory=lambda: MaterialBox((5e8, 6e9), (0.2, 0.49), (0.005, 0.2)))
    tolerance_cards: Mapping[str, EffectCard] = field(default_factory=dict)

    @property
    def cards(self) -> Mapping[str, EffectCard]:
        return CARDS

    def counted(self, laws: Sequence[LocalLaws], effects: Iterable[str]) -> "NavierPanel":
        del laws, effects
        return self

    @cached_property
    def numbers(self) -> Real:
        found = np.array([(m, n) for m in range(1, self.waves + 1) for n in range(1, self.waves + 1)], float)
        return found * np.pi / np.array([A, B])

    def shape(self, x: float, y: float) -> Real:
        kx, ky = self.numbers.T
        return 2.0 / np.sqrt(DENSITY * H * A * B) * np.sin(kx * x) * np.sin(ky * y)

    def bending(self, x: float, y: float, nu: float, weights: tuple[Real, Real]) -> Real:
        """Stiffness of a small piece of plate about (x, y), for unit D, by quadrature; (N, N)."""
        offsets, areas = weights
        kx, ky = self.numbers.T
        scale = 2.0 / np.sqrt(DENSITY * H * A * B)
        px, py = np.multiply.outer(x + offsets[:, 0], kx), np.multiply.outer(y + offsets[:, 1], ky)
        xx, yy = -scale * kx**2 * np.sin(px) * np.sin(py), -scale * ky**2 * np.sin(px) * np.sin(py)
        xy = scale * kx * ky * np.cos(px) * np.cos(py)

        def over(one: Real, other: Real) -> Real:
            return np.asarray((one * areas[:, None]).T @ other)

        cross = over(xx, yy)
        return over(xx, xx) + over(yy, yy) + nu * (cross + cross.T) + 2.0 * (1.0 - nu) * over(xy, xy)

    def coupling(self, centre: tuple[float, float]) -> Real:
        """Mean of the sum of curvatures over a patch, in closed form."""
        kx, ky = self.numbers.T
        spread = np.sinc(kx * self.half / np.pi) * np.sinc(ky * self.half / np.pi)
        return self.shape(*centre) * -(kx**2 + ky**2) * spread

    def _disc(self) -> tuple[Real, Real]:
        radii = RADIUS * np.sqrt((np.arange(3) + 0.5) / 3)
        angles = np.arange(8) * np.pi / 4
        offsets = np.array([(r * np.cos(t), r * np.sin(t)) for r in radii for t in angles])
        return offsets, np.full(len(offsets), np.pi * RADIUS**2 / len(offsets))

    def _square(self) -> tuple[Real, Real]:
        nodes, weights = np.polynomial.legendre.leggauss(4)
        offsets = np.array([(self.half * p, self.half * q) for p in nodes for q in nodes])
        return offsets, np.array([self.half**2 * v * w for v in weights for w in weights])

    def system(self, law: tuple[float, float, float], source: int, on: Effects) -> System:
        """Stiffness and mass (N, N), load (N,) and readings (K, N)."""
        e, nu, eta = law
        rigidity = e * H**3 / 12.0 / (1.0 - nu**2) * (1.0 + 1j * eta)
        kx, ky = self.numbers.T
        stiffness = np.diag(((kx**2 + ky**2) ** 2) / (DENSITY * H)).astype(complex) * rigidity
        inertia = np.eye(len(kx), dtype=complex)
        names = [
            *(f"A{k + 1}" for k in range(len(self.actuators))),
            *(f"S{k + 1}" for k in range(len(self.sensors))),
        ]
        held = {name: 1.0 - on.get("patch_debond", {}).get(name, 0.0) for name in names}
        for name, patch in zip(names, self._patch_stiffness, strict=True):
            stiffness = stiffness + held[name] * patch
        if "local_damage" in on:
            x, y, loss = (on["local_damage"][key] for key in ("x", "y", "loss"))
            stiffness = stiffness - loss * rigidity * self.bending(x, y, nu, self._disc())
        if "mass_at_place" in on:
            at = self.shape(on["mass_at_place"]["x"], on["mass_at_place"]["y"])
            inertia = inertia + on["mass_at_place"]["mass"] * np.outer(at, at)
        if "spring_at_place" in on:
            at = self.shape(on["spring_at_place"]["x"], on["spring_at_place"]["y"])
            stiffness = stiffness + on["spring_at_place"]["stiffness"] * np.outer(at, at)
        load = held[names[source]] * self.coupling(self.actuators[source])
        read = [held[f"S{k + 1}"] * self.coupling(centre) for k, centre in enumerate(self.sensors)]
        return stiffness, inertia, load.astype(complex), 1e-9 * np.array(read, dtype=complex)

    @cached_property
    def _patch_stiffness(self) -> list[Real]:
        """Of ceramics, which do not soften with temperature."""
        ceramic = 2e9 * H**3 / 12.0 * self.patch_share
        return [ceramic * self.bending(*c, 0.3, self._square()) for c in (*self.actuators, *self.sensors)]

    def frf(
        self, laws: LocalLaws, frequency: Real, effects: Effects = NO_EFFECTS, point: SweepPoint | None = None
    ) -> Complex:
        return self.linearise(laws, frequency, effects, point).transfer

    def linearise(
        self,
        laws: LocalLaws,
        frequency: Real,
        effects: Effects = NO_EFFECTS,
        point: SweepPoint | None = None,
        tangents: Sequence[Tangent] = (),
    ) -> Linearisation:
        t = laws.reference if point is None else point.temperature
        source = 0 if point is None else point.source
        law = tuple(float(f(t)) for f in (laws.youngs_modulus, laws.poisson_ratio, laws.loss_factor))
        stiffness, inertia, load, read = self.system(law, source, effects)
        omega2 = (2.0 * np.pi * frequency) ** 2
        dynamic = stiffness - omega2[:, None, None] * inertia
        sides = np.column_stack([load, read.T])
        solved = np.linalg.solve(dynamic, np.broadcast_to(sides, (len(omega2), *sides.shape)))
        moved, adjoint = solved[..., 0], solved[..., 1:]

        def by(up: System, down: System, step: float) -> Complex:
            dk, dm, dload, dread = ((a - b) / (2.0 * step) for a, b in zip(up, down, strict=True))
            inner = moved @ dk.T - omega2[:, None] * (moved @ dm.T) - dload
            return (moved @ dread.T - np.einsum("fn,fnk->fk", inner, adjoint)).T

        e, nu, eta = law
        d = STEP
        steps = [
            ((e * np.exp(d), nu, eta), (e * np.exp(-d), nu, eta)),
            ((e, nu + d, eta), (e, nu - d, eta)),
            ((e, nu, eta * np.exp(d)), (e, nu, eta * np.exp(-d))),
        ]
        material = np.array(
            [by(self.system(p, source, effects), self.system(m, source, effects), d) for p, m in steps]
        )
        parameters = []
        for name, parameter, values in tangents:
            here = dict(effects.get(name, values))
            h = {"kg": 1e-6, "N/m": 1.0, "m": 1e-5}.get(
                next(p.unit for p in CARDS[name].parameters if p.name == parameter), 1e-4
            )
            up, down = ({**effects, name: {**here, parameter: here[parameter] + s * h}} for s in (1.0, -1.0))
            parameters.append(by(self.system(law, source, up), self.system(law, source, down), h))
        plain = (moved @ read.T).T
        nothing = np.zeros((3, *plain.shape), dtype=complex)
        by_parameter = np.array(parameters) if parameters else np.zeros((0, *plain.shape), dtype=complex)
        slope = np.tensordot(laws.rates(t), material, 1)
        return Linearisation(plain, material, nothing, nothing, slope, by_parameter)
