"""Effects that are not in the library, hidden in a trial to test the verdict unknown.

They act on the simulated plate only, through the same states as the library's effects.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from analysis.arrays import Complex, Real
from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from analysis.sweep_point import SweepPoint
from app.rig.plate_transfer import Followed, TwinTransfer
from simulation.effects.effect import Effect
from simulation.state.plate_state import Circumstances, Disc, PlateState, PointLoad

Values = Mapping[str, Any]

STIFFENER_RADIUS = 0.015
"""m."""


def _card(name: str, summary: str, *parameters: Parameter) -> EffectCard:
    site = {p.name: p.typical for p in parameters if p.shape}
    return EffectCard(name, summary, parameters, needs="", separated_by="", sites=(site,))


def _stiffener_card(experiment: Experiment) -> EffectCard:
    low, high = experiment.plate.bounds
    return _card(
        "stiffener",
        "a disc glued on makes a spot stiffer",
        Parameter("gain", "1", 0.0, 2.0, 0.3),
        Parameter("x", "m", low[0] + STIFFENER_RADIUS, high[0] - STIFFENER_RADIUS, 0.1, shape=True),
        Parameter("y", "m", low[1] + STIFFENER_RADIUS, high[1] - STIFFENER_RADIUS, 0.1, shape=True),
    )


def _stiffened(state: PlateState, circumstances: Circumstances, values: Values) -> PlateState:
    disc = Disc(values["x"], values["y"], STIFFENER_RADIUS, -values["gain"])
    return state.with_(discs=(*state.discs, disc))


def _spring_card(experiment: Experiment) -> EffectCard:
    return _card(
        "hidden_spring",
        "something holds the plate at an undeclared point",
        Parameter("stiffness", "N/m", 0.0, 3e4, 1000.0),
    )


def _sprung(state: PlateState, circumstances: Circumstances, values: Values) -> PlateState:
    load = PointLoad(circumstances.cables[-1], stiffness=values["stiffness"])
    return state.with_(point_loads=(*state.point_loads, load))


def _resonance(name: str, experiment: Experiment) -> Parameter:
    """Frequency somewhere in the band."""
    low, high = experiment.protocol.band
    return Parameter(name, "Hz", low, high, 100.0, shape=True, typical=0.5 * (low + high))


def _oscillator(ratio: Real, quality: float) -> tuple[Real, Real]:
    """Real part of 1/(1 - s**2 + j s/Q), and minus its imaginary part."""
    below, lost = 1.0 - ratio**2, ratio / quality
    size = below**2 + lost**2
    return below / size, lost / size


def _cavity_card(experiment: Experiment) -> EffectCard:
    return _card(
        "cavity",
        "the air between plate and table resonates",
        Parameter("mass", "kg/m2", 0.0, 0.5, 0.02),
        _resonance("resonance", experiment),
    )


def _above_cavity(state: PlateState, circumstances: Circumstances, values: Values) -> PlateState:
    """Impedance per area of a mass that follows through a spring: j w m / (1 - s**2 + j s/Q), Q = 12."""
    real, lost = _oscillator(circumstances.frequency / values["resonance"], 12.0)
    omega = 2.0 * np.pi * circumstances.frequency
    return state.with_(
        area_mass=state.area_mass + values["mass"] * real,
        area_resistance=state.area_resistance + values["mass"] * omega * lost,
    )


def _filter_card(experiment: Experiment) -> EffectCard:
    return _card(
        "filter_ripple",
        "a conditioner's second-order filter rings inside the band",
        Parameter("height", "1", 0.0, 0.5, 0.02),
        _resonance("corner", experiment),
    )


def _filtered(state: PlateState, circumstances: Circumstances, values: Values) -> PlateState:
    """Multiply responses by 1 + height s j/Q / (1 - s**2 + j s/Q), Q = 4."""
    s = circumstances.frequency / values["corner"]
    through, lost = _oscillator(s, 4.0)
    height = values["height"] * s / 4.0
    real, imaginary = 1.0 + height * lost, height * through
    return state.with_(
        log_gain=state.log_gain + 0.5 * np.log(real**2 + imaginary**2),
        phase=state.phase + np.arctan(imaginary / real),
    )


SPRING = Effect(_spring_card, _sprung)
UNLISTED_EFFECTS: Mapping[str, Effect] = {
    "stiffener": Effect(_stiffener_card, _stiffened),
    "hidden_spring": SPRING,
    "cavity": Effect(_cavity_card, _above_cavity),
    "filter_ripple": Effect(_filter_card, _filtered),
}
"""All except the resonator, whose force depends on frequency."""


def _resonator_card(experiment: Experiment) -> EffectCard:
    return _card(
        "resonator",
        "a mass on a spring sits at an undeclared point",
        Parameter("mass", "kg", 0.0, 0.02, 1e-4),
        _resonance("resonance", experiment),
    )


RESONATOR = Effect(_resonator_card, lambda state, circumstances, values: state)


@dataclass(frozen=True)
class ResonatorTransfer:
    """A plate with a mass on a lossy spring at its hidden point.

    A force at a point changes a plate by rank one: every transfer is a Moebius function of the dynamic stiffness d
    there, (a + b d)/(1 + c d). The bare plate and two plain springs give a, b and c on every line.

    Attributes
    ----------
    plain : TwinTransfer
        Its library holds `hidden_spring`, which is off.
    mass, resonance, loss : float
        kg, Hz, of the spring.
    """

    plain: TwinTransfer
    mass: float
    resonance: float
    loss: float = 0.03
    probes: tuple[float, float] = (2e3, 2e4)

    @property
    def band(self) -> tuple[float, float]:
        """Band of the plate, Hz."""
        return self.plain.band

    @property
    def outputs(self) -> int:
        """Number of sensors."""
        return self.plain.outputs

    @property
    def follows(self) -> Followed:
        """Circumstances on which the plate without the resonator depends."""
        return self.plain.follows

    def __call__(self, point: SweepPoint, frequency: Real) -> Complex:
        """Transfer (K, F)."""
        bare = self.plain(point, frequency)
        first, second = (self._sprung(d)(point, frequency) for d in self.probes)
        one, other = ((h - bare) / d for h, d in zip((first, second), self.probes, strict=True))
        c = (one - other) / (second - first)
        b = one + c * first
        omega = 2.0 * np.pi * frequency
        spring = self.mass * (2.0 * np.pi * self.resonance) ** 2 * (1.0 + 1j * self.loss)
        d = -(omega**2) * self.mass * spring / (spring - omega**2 * self.mass)
        return np.asarray((bare + b * d) / (1.0 + c * d))

    def _sprung(self, stiffness: float) -> TwinTransfer:
        effects = {**self.plain.effects, "hidden_spring": {"stiffness": stiffness}}
        return TwinTransfer(self.plain.twin, self.plain.laws, effects)
