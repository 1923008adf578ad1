"""A toy twin with closed forms: few modes, effects of every kind that the workflow has to tell apart."""

from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from itertools import product

import numpy as np
import pytest

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Protocol
from analysis.gap.data.preparation import prepare
from analysis.gap.fitting.state import plain_state
from analysis.material import LocalLaws, Material, MaterialBox
from analysis.recordings.frf import Frf
from analysis.recordings.sweep_point import SweepPoint
from analysis.twin_model import Linearisation, ModalParts
from analysis.updated import Updated

MODES = 10
STEP = 1e-5


def effect(name, *parameters, sites=({},)):
    return EffectCard(name, f"toy {name}", parameters, f"what {name} needs", f"what tells {name}", sites)


CARDS = {
    c.name: c
    for c in (
        effect("stretch", Parameter("delta_e", "1", -0.3, 0.3, 0.05), Parameter("delta_g", "1", -0.3, 0.3, 0.05)),
        effect("mass", Parameter("grams", "g", 0.0, 10.0, 1.0)),
        effect("lag", Parameter("tau", "s", 0.0, 900.0, 200.0)),
        effect("taper", Parameter("tx", "1", -0.2, 0.2, 0.02)),
        effect("draught", Parameter("gx", "K", -10.0, 10.0, 2.0)),
        effect("drift", Parameter("alpha", "1/K", -0.01, 0.01, 0.002)),
        effect(
            "bond",
            Parameter("gamma", "1", 0.0, 1.0, 0.1),
            Parameter("softening", "1/K", 0.0, 0.1, 0.02, shape=True, typical=0.03),
            sites=({"softening": 0.03},),
        ),
        effect(
            "damage",
            Parameter("loss", "1", 0.0, 0.5, 0.1),
            Parameter("x", "1", 0.05, 0.95, 0.3, shape=True, typical=0.5),
            sites=tuple({"x": x} for x in np.arange(0.06, 0.5, 0.04)),
        ),
        effect("softening", Parameter("a", "1", -0.2, 0.2, 0.05), Parameter("b", "1", -0.2, 0.2, 0.05)),
        effect("delay", Parameter("seconds", "s", -1e-3, 1e-3, 5e-6)),
        effect("feedthrough", Parameter("gain", "V/V", -0.1, 0.1, 0.01)),
    )
}


@dataclass
class ToyPlate:
    """Modes whose stiffness, mass and coupling the effects change; derivatives by central differences."""

    channels: int = 2
    left_out: tuple[str, ...] = ()
    calls: list[SweepPoint] = field(default_factory=list)

    @property
    def box(self):
        return MaterialBox((0.5e9, 5e9), (0.2, 0.48), (0.01, 0.2))

    @property
    def tolerance_cards(self):
        return {}

    @property
    def cards(self):
        return {name: card for name, card in CARDS.items() if name not in self.left_out}

    def modes(self):
        rng = np.random.default_rng(7)
        frequency = np.linspace(140.0, 1350.0, MODES) * (1.0 + 0.03 * rng.standard_normal(MODES))
        residue = rng.uniform(0.3, 1.0, (self.channels, MODES)) * rng.choice([-1.0, 1.0], (self.channels, MODES))
        by_nu = rng.uniform(-0.8, 0.8, MODES)
        patterns = rng.standard_normal((5, MODES))
        patterns[4] = patterns[3] + 0.1 * rng.standard_normal(MODES)  # the look-alikes
        return frequency, residue, by_nu, patterns

    def transfer(self, point, laws, effects: Mapping, frequency):
        added = effects["feedthrough"]["gain"] if "feedthrough" in effects else 0.0
        return self.modal_parts(laws, frequency, effects, point).parts.sum(axis=0) + added

    def modal_parts(self, laws, frequency, effects, point):
        f0, residue, by_nu, pattern = self.modes()

        def on(name, parameter):
            return effects[name][parameter] if name in effects else 0.0

        t = point.temperature - on("lag", "tau") * point.rate
        e, nu, eta = laws.youngs_modulus(t), laws.poisson_ratio(t), laws.loss_factor(t)
        slope = laws.slope[0] + (t - laws.reference) * laws.curvature[0]
        square = (2 * np.pi * f0) ** 2 * (e / 2e9) * (1.0 + by_nu * (nu - 0.33))
        square = square * (1.0 + on("stretch", "delta_e") * pattern[0] + on("stretch", "delta_g") * pattern[1])
        square = square * (1.0 + on("taper", "tx") * pattern[3]) * (1.0 + on("draught", "gx") * slope * pattern[4])
        square = square / (1.0 + 0.01 * on("mass", "grams") * residue[0] ** 2)
        if "damage" in effects:
            place = np.sin(np.pi * np.arange(1, MODES + 1) * effects["damage"]["x"]) ** 2
            square = square * (1.0 - 0.3 * effects["damage"]["loss"] * place)
        soft = point.level**2 * residue[0] ** 2
        loss = eta * (1.0 + on("softening", "b") * soft)
        square = square * (1.0 - on("softening", "a") * soft)
        if "bond" in effects:
            values = effects["bond"]
            weak = values["gamma"] * np.exp(values["softening"] * (point.temperature - 25.0))
            residue = residue / (1.0 + weak)
            square = square * (1.0 - 0.02 * weak * pattern[2] ** 2)
        residue = np.roll(residue, 3 * point.source, axis=1)  # another place drives the same modes
        omega = 2 * np.pi * frequency
        poles = square * (1.0 + 1j * loss * np.ones(MODES))
        strength = 0.02 * residue.T * ((2 * np.pi * f0) ** 2 * eta_scale(f0))[:, None]
        strength = strength * (1.0 + on("drift", "alpha") * (point.temperature - 25.0))
        delayed = np.exp(-1j * omega * on("delay", "seconds")) / (poles[:, None] - omega**2)
        return ModalParts(poles, strength[:, :, None] * delayed[:, None], frequency)

    def frf(self, laws, frequency, effects, point):
        return self.transfer(point, laws, effects, frequency)

    def counted(self, laws, effects):
        return self

    def linearise(self, laws, frequency, effects, point, tangents=()):
        self.calls.append(point)

        def at(point=point, laws=laws, effects=effects):
            return self.transfer(point, laws, effects, frequency)

        def by(changed):
            return np.array([(at(laws=changed(s)) - at(laws=changed(-s))) / (2 * STEP) for s in STEP * np.eye(3)])

        flat = np.zeros(3)
        by_laws = (
            by(lambda s: replace(laws, value=laws.value + s)),
            by(lambda s: laws.tilted(s, flat, point.temperature)),
            by(lambda s: laws.tilted(flat, s, point.temperature)),
        )
        warm, cold = (replace(point, temperature=point.temperature + s * 1e-3) for s in (1, -1))
        by_parameter = []
        for name, parameter, values in tangents:
            values = effects.get(name, values)
            card = next(p for p in {**CARDS, **self.cards}[name].parameters if p.name == parameter)
            h = 1e-4 * card.sigma
            pair = [{**effects, name: {**values, parameter: values[parameter] + s * h}} for s in (1, -1)]
            by_parameter.append((at(effects=pair[0]) - at(effects=pair[1])) / (2 * h))
        transfer = at()
        return Linearisation(
            transfer,
            *by_laws,
            (at(point=warm) - at(point=cold)) / 2e-3,
            np.array(by_parameter).reshape(-1, *transfer.shape),
        )


def eta_scale(f0):
    """All resonances about equally high."""
    return 0.05 * np.ones_like(f0)


def true_laws(temperature):
    """Log E, nu and log eta (T, 3) of a polymer that softens."""
    t = np.asarray(temperature, dtype=float)
    return np.stack(
        [
            np.log(2e9) - 0.012 * (t - 25.0) - 0.1 * np.tanh((t - 10.0) / 15.0),
            0.33 + 0.0006 * (t - 25.0),
            np.log(0.05) + 0.006 * (t - 25.0),
        ],
        axis=-1,
    )


def protocol(temperatures, directions=("up", "down"), levels=(1.0,)):
    return Protocol(
        sweep="logarithmic",
        band=(100.0, 1500.0),
        sweep_duration=2.0,
        tail=0.4,
        repeats=3,
        ramp_rate=0.4,
        temperatures=tuple(temperatures),
        directions=directions,
        levels=levels,
    )


GAIN = 11.0
GAINS = (11.0, 7.5)
"""Of the first input and of a second one."""


def record(
    effects=None,
    *,
    temperatures=(2.0, 10.0, 18.0, 26.0, 34.0, 42.0, 50.0, 58.0),
    directions=("up", "down"),
    levels=(1.0,),
    channels=2,
    noise=0.01,
    seed=1,
    stated=1.0,
    spacing=1.0,
    extra=None,
    reading_sigma=0.035,
    sources=(0,),
    plate=None,
):
    """FRFs of a toy campaign and its protocol; `stated` is stated over true standard deviation of the noise.

    Each of `sources` drives in its turn. `plate` is another than the twin.
    """
    rng = np.random.default_rng(seed)
    plate = plate or ToyPlate(channels)
    frequency = np.arange(100.0, 1500.0 + spacing / 2, spacing)
    h, variance, readings, ways, drives, driven_by = [], [], [], [], [], []
    for way in directions:
        for t in temperatures if way == "up" else reversed(temperatures):
            for level, source in product(levels, sources):
                true = t + 0.02 * rng.standard_normal()
                slope = (true_laws(true + 0.01) - true_laws(true - 0.01)) / 0.02
                curvature = (true_laws(true + 0.1) - 2 * true_laws(true) + true_laws(true - 0.1)) / 0.01
                laws = LocalLaws(true, true_laws(true), slope, curvature)
                point = SweepPoint(true, (1 if way == "up" else -1) * 0.4 / 60.0, level, source)
                point = replace(point, level=level * GAINS[source] / GAINS[0])
                clean = plate.transfer(point, laws, effects or {}, frequency)
                if extra is not None:
                    clean = clean + extra(frequency, true)
                clean = GAINS[source] * clean
                power = noise**2 * (np.abs(clean) ** 2).mean(-1, keepdims=True) * (300.0 / frequency)
                error = rng.standard_normal(clean.shape) + 1j * rng.standard_normal(clean.shape)
                h.append(clean + np.sqrt(power / 2.0) * error)
                variance.append(stated**2 * power)
                readings.append(true + reading_sigma * rng.standard_normal())
                ways.append(way)
                drives.append(level)
                driven_by.append(source)
    frf = Frf(
        temperature=np.array(readings),
        direction=tuple(ways),
        level=np.array(drives),
        frequency=frequency,
        h=np.array(h),
        variance=np.array(variance),
        coherence=np.full((len(h), channels, len(frequency)), 0.99),
        excluded=np.abs(frequency - 50.0 * np.round(frequency / 50.0)) < 1.5 * spacing,
        channels=tuple(f"S{k + 1}" for k in range(channels)),
        source=np.array(driven_by) if max(sources) else None,
        sources=("A1", "A2") if max(sources) else (),
    )
    return frf, protocol(temperatures, directions, levels)


def start_near(groups, *, off=0.005, inputs=1):
    """Start as model updating would give it: right to half a percent."""
    laws = true_laws(groups.reference) + off * np.array([1.0, 0.2, 2.0])
    return plain_state(groups, laws, np.log(GAINS[:inputs]) + off, {})


def updated(frf, *, off=0.004):
    """Model updating of a toy campaign, right to half a percent."""
    laws = true_laws(frf.temperature) + off * np.array([1.0, 0.2, 2.0])
    material = Material(np.exp(laws[:, 0]), laws[:, 1], np.exp(laws[:, 2]))
    zeros = np.zeros(len(laws))
    return Updated(
        temperature=frf.temperature,
        material=material,
        sigma=material,
        correlation=np.zeros((len(laws), 4, 4)),
        gain=GAIN * (1.0 + off),
        sigma_gain=0.0,
        misfit_start=zeros,
        misfit=zeros,
        noise_floor=zeros,
        chi2_per_dof=zeros,
        settled=np.ones(len(laws), dtype=bool),
        further=None if frf.source is None else np.array([[GAINS[1] * (1.0 + off), 0.0]]),
    )


@pytest.fixture(scope="session")
def pool():
    """Two threads, as the workflow has them."""
    with ThreadPoolExecutor(2) as executor:
        yield executor


@pytest.fixture(scope="session")
def toy():
    """Hand out the toy's makers in one place."""
    return ToyTools


def placed_plate(cards, size=lambda one, frequency: one["grams"]):
    """Return a plate whose resonances a thing of some size shifts alike at all images of its place.

    Residues tell the images apart. `size` gives that of one effect by its values and the frequencies.
    """

    class Placed(ToyPlate):
        here = ()

        @property
        def cards(self):
            return cards

        def modes(self):
            frequency, residue, by_nu, patterns = super().modes()
            n = np.arange(1, len(frequency) + 1)
            for one in self.here:
                x, y, share = np.pi * one["x"], np.pi * one["y"], 0.01 * size(one, frequency)
                lean = np.cos(x) + 0.5 * np.cos(y) + np.cos(x) * np.cos(y)
                frequency = frequency * (1.0 - share * np.sin(n * x) ** 2 * np.sin((n % 5 + 1) * y) ** 2)
                residue = residue * (1.0 + share * lean * np.cos(n))
            return frequency, residue, by_nu, patterns

        def transfer(self, point, laws, effects, frequency):
            other = Placed(self.channels)
            other.here = tuple(effects.values())
            return ToyPlate.transfer(other, point, laws, {}, frequency)

    return Placed(2)


def bounded_plate(plate, effect, shape, low):
    """Return a plate of which a shape of one effect begins at `low`, and is told inside its range only."""

    class Bounded(ToyPlate):
        @property
        def cards(self):
            card = plate.cards[effect]
            narrow = (replace(p, low=low, only_inside=True) if p.name == shape else p for p in card.parameters)
            return {**plate.cards, effect: replace(card, parameters=tuple(narrow))}

    return Bounded(plate.channels, plate.left_out)


class ToyTools:
    Plate = ToyPlate
    bounded = staticmethod(bounded_plate)
    placed = staticmethod(placed_plate)
    cards = CARDS
    gain = GAIN
    gains = GAINS
    record = staticmethod(record)
    laws = staticmethod(true_laws)
    start = staticmethod(start_near)
    protocol = staticmethod(protocol)
    updated = staticmethod(updated)

    @staticmethod
    def prepared(**kwargs):
        """Sweeps and noise check of a toy campaign."""
        frf, rig = record(**kwargs)
        return prepare(frf, rig, updated(frf))
