"""Description of an unknown cause: where it acts, by which law and on what it depends, without a name.

Every form is fitted in full, with laws and gain: a load of any frequency dependence at a place, found from the
map's best places, then loads of simple forms from there; a modulus, a loss factor and a gain over frequency. The
form with the most evidence describes the cause.

At the fit, the cause's whole signal in the sweeps of one temperature (ramp, level, ...) is one unknown, and laws,
readings and gain are eliminated: to first order, its strength there over that of the fit to all.

What an unknown cause is like: a load at a place, a modulus or a gain over frequency, and what it depends on.
"""

from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Complex, Real
from analysis.effect_card import EffectCard, Values
from analysis.estimates import Estimate
from analysis.gap.data.sweeps import GapSweeps
from analysis.gap.description.place_map import PlaceMap, PlaceTangents, place_map
from analysis.gap.fitting.fit import fit_gap
from analysis.gap.fitting.gap_fit import GapFit
from analysis.gap.fitting.normal_equations import WhitenedSweep, whiten_all
from analysis.gap.fitting.schur_complement import schur_complement
from analysis.gap.fitting.state import GapState
from analysis.gap.thresholds import CLASS_NATS
from analysis.progress import Progress
from analysis.twin_model import Tangent, TwinModel

CONSTANT, VARIES = 3.0, 0.1
"""A cause counts as the same in all circumstances if no factor is this many sigma, or this share, from 1."""


@dataclass(frozen=True)
class Curve:
    """Two curves over frequency.

    Attributes
    ----------
    frequency : (B,) ndarray, Hz
    value, sigma : (2, B) ndarray
        Of a load: its apparent mass, real and minus imaginary part, kg. Of a modulus: relative change of storage
        modulus and loss factor. Of a gain: of its logarithm, and phase, rad.
    """

    frequency: Real
    value: Real
    sigma: Real


@dataclass(frozen=True)
class Form:
    """One form that a cause may have, as fitted.

    Attributes
    ----------
    name : str
        ``mass``, ``spring``, ``dashpot``, ``resonator``, ``load``, ``modulus``, ``gain``.
    effect : str
        By which it was computed.
    values : mapping
        Of that effect.
    parameters : tuple of Estimate
        The same with standard deviations.
    nats : float
        Log evidence over the twin without it.
    share : float
        Share of the excess over the noise that it explains.
    curve : Curve or None
    also : tuple of (float, float)
        Other places from which it explains as much, m.
    """

    name: str
    effect: str
    values: Values
    parameters: tuple[Estimate, ...]
    nats: float
    share: float
    curve: Curve | None = None
    also: tuple[tuple[float, float], ...] = ()

    @property
    def place(self) -> tuple[Estimate, Estimate] | None:
        """Where it acts; None where it is no load at a place."""
        known = {one.name: one for one in self.parameters}
        return (known["x"], known["y"]) if {"x", "y"} <= set(known) else None


@dataclass(frozen=True)
class Dependence:
    """How a cause's strength changes with one circumstance.

    Attributes
    ----------
    on : str
        ``temperature``, ``ramp``, ``level``, ``channel``, ``time``.
    label : tuple of str
        Of each value of the circumstance.
    factor, sigma : (L,) ndarray
        Strength over that of the fit to all sweeps.
    """

    on: str
    label: tuple[str, ...]
    factor: Real
    sigma: Real

    @property
    def constant(self) -> bool:
        """Whether it is the same throughout, as far as the data say."""
        away = abs(self.factor - 1.0)
        return bool(((away < CONSTANT * self.sigma) | (away < VARIES)).all())


@dataclass(frozen=True)
class Description:
    """Description of what a twin lacks and no effect explains.

    Attributes
    ----------
    best : Form
        The form with most evidence.
    forms : tuple of Form
        All that were fitted, most evidence first.
    map : PlaceMap
    dependence : tuple of Dependence
        Of the best form.
    beside : mapping
        Effects that were on.
    """

    best: Form
    forms: tuple[Form, ...]
    map: PlaceMap = field(repr=False)
    dependence: tuple[Dependence, ...]
    beside: Mapping[str, Values]


TIMES = 3
"""Parts of the campaign, in the order of its sweeps."""
MOST = 12
"""Temperatures told apart: neighbours are taken together beyond."""
TEMPERATURES = 5
"""Temperatures of the fits: enough for a place and a law, and a sixth of a campaign's cost."""
PLACES = 4
"""Best places of the map from which a load is fitted."""
BANDS = 8
"""Bands of frequency in which a load is free when places are compared."""
RESONANCES = 3
"""Frequencies from which a resonator is fitted: where the free load is largest."""
APART = 0.015
"""Distance from which another place is another answer, m."""
STEPS = 12
"""Linearisations of one fit."""


@dataclass(frozen=True)
class Vocabulary:
    """Effects of a model by which causes are described.

    Attributes
    ----------
    loads : mapping of str to str
        Effect of each form of a load at a place: ``mass``, ``spring``, ``dashpot``, ``resonator``.
    load, modulus, gain : str
        Effects of curves without a formula: amplitudes ``a0``, ``a1``, ..., ``b0``, ``b1``, ...
    knots : mapping of str to ndarray
        Frequencies of the amplitudes of these three, Hz.
    """

    loads: Mapping[str, str]
    load: str
    modulus: str
    gain: str
    knots: Mapping[str, Real]


@dataclass(frozen=True)
class _Bench:
    model: TwinModel
    sweeps: GapSweeps
    base: GapFit
    executor: Executor
    errors: float

    def fitted(self, effect: str, start: Values) -> GapFit:
        beside = tuple(self.base.state.effects)
        state = self.base.state.with_effects({**self.base.state.effects, effect: start})
        return fit_gap(self.model, self.sweeps, state, (*beside, effect), self.executor, most_steps=STEPS)

    def best(self, effect: str, starts: Sequence[Values]) -> GapFit:
        return max((self.fitted(effect, start) for start in starts), key=lambda fit: fit.log_evidence)


def describe(
    model: TwinModel,
    exact: TwinModel,
    sweeps: GapSweeps,
    start: GapState,
    vocabulary: Vocabulary,
    executor: Executor,
    report: Progress,
) -> Description:
    """Describe what a twin lacks.

    Parameters
    ----------
    model : TwinModel
        With the effects of the vocabulary.
    exact : TwinModel
        The same with all that is declared taken as exact: forms are compared with it, because the unknown pulls
        at every quantity that is free, and each costs time. The best form is fitted once more with `model`.
    sweeps : GapSweeps
    start : GapState
        Of the twin without the unknown; effects that are on are fitted again beside it.
    vocabulary : Vocabulary
    executor : Executor
        Sweeps are linearised on it.
    report : callable
        Called with a stage's name and the share of it done.

    Returns
    -------
    Description

    Raises
    ------
    ValueError
        Where the model refuses the start.
    """
    report("description", 0.0)
    few = _few(sweeps)
    begun = replace(start.restricted(sweeps, few), declared={})
    base = fit_gap(exact, few, begun, tuple(start.effects), executor)
    bench = _Bench(exact, few, base, executor, max(base.total / base.dof, 1.0) * few.overstated)
    tangents = PlaceTangents.of(exact, few, base, vocabulary.loads["mass"], executor, bench.errors)
    report("description", 0.2)
    load = _located(bench, tangents, vocabulary)
    report("description", 0.4)
    fits = {"load": (vocabulary.load, load), **_simple_loads(bench, vocabulary, load)}
    report("description", 0.6)
    for name, effect in (("modulus", vocabulary.modulus), ("gain", vocabulary.gain)):
        fits[name] = (effect, bench.fitted(effect, exact.cards[effect].zero()))
    report("description", 0.7)
    forms = [_form(bench, name, effect, fit, vocabulary) for name, (effect, fit) in fits.items()]
    best = max(forms, key=lambda form: form.nats)
    others = _elsewhere(bench, best, tangents, fits[best.name][1])
    report("description", 0.8)
    names = (*start.effects, best.effect)
    last = fit_gap(model, few, fits[best.name][1].state, names, executor, most_steps=STEPS)
    best = replace(best, **_estimated(last, best.effect, vocabulary), also=others)
    errors = max(last.total / last.dof, 1.0) * few.overstated
    depends = dependences(model, few, last, best.effect, executor, errors)
    report("description", 1.0)
    rest = sorted((form for form in forms if form.name != best.name), key=lambda form: -form.nats)
    return Description(best, (best, *rest), place_map(tangents), depends, dict(start.effects))


def _elsewhere(bench: _Bench, best: Form, tangents: PlaceTangents, fit: GapFit) -> tuple[tuple[float, float], ...]:
    """Return other places from which the same form explains as much: mirror images, on plates that have them."""
    if best.place is None:
        return ()
    x, y = best.place[0].value, best.place[1].value
    card = bench.model.cards[best.effect]
    low, high = (
        np.array([getattr(p, end) for p in card.parameters if p.name in ("x", "y")]) for end in ("low", "high")
    )
    (left, down), (right, up) = low, high
    images = [(left + right - x, y), (x, down + up - y), (left + right - x, down + up - y)]
    found: list[tuple[float, float]] = []
    for image in images:
        nearest = np.linalg.norm(tangents.places - image, axis=1).min()
        if nearest > np.linalg.norm(high - low) / np.sqrt(len(tangents.places)):
            continue  # off the plate, or in a hole
        try:
            other = bench.fitted(best.effect, {**best.values, "x": image[0], "y": image[1]})
        except ValueError:
            continue
        there = other.state.effects[best.effect]
        place = float(there["x"]), float(there["y"])
        behind = (fit.log_evidence - other.log_evidence) / max(fit.total / fit.dof, 1.0) / bench.sweeps.overstated
        known = [(x, y), *found]
        if behind < CLASS_NATS and min(np.hypot(place[0] - a, place[1] - b) for a, b in known) > APART:
            found.append(place)
    return tuple(found)


def _few(sweeps: GapSweeps) -> GapSweeps:
    count = len(sweeps.groups.reference)
    if count <= TEMPERATURES:
        return sweeps
    return sweeps.only_groups(sorted({round(i * (count - 1) / (TEMPERATURES - 1)) for i in range(TEMPERATURES)}))


def _located(bench: _Bench, tangents: PlaceTangents, vocabulary: Vocabulary) -> GapFit:
    """Fit a free load from the places where, free in bands, it has the most evidence."""
    bands: Complex = _bands(tangents.frequency)
    evidence = tangents.evidence(np.concatenate([bands, -1j * bands]))
    card = bench.model.cards[vocabulary.load]
    chosen = np.argsort(-evidence)[:PLACES]
    starts = [card.zero({"x": float(x), "y": float(y)}) for x, y in tangents.places[chosen]]
    return bench.best(vocabulary.load, starts)


def _bands(frequency: Real) -> Complex:
    edges = np.geomspace(frequency[0], frequency[-1], BANDS + 1)
    place = np.clip(np.searchsorted(edges, frequency, side="right") - 1, 0, BANDS - 1)
    return np.asarray(place == np.arange(BANDS)[:, None], dtype=complex)


def _simple_loads(bench: _Bench, vocabulary: Vocabulary, load: GapFit) -> dict[str, tuple[str, GapFit]]:
    """Fit loads of simple forms from where the free load was found."""
    values = load.state.effects[vocabulary.load]
    place = {"x": values["x"], "y": values["y"]}
    knots = vocabulary.knots[vocabulary.load]
    size = [np.hypot(values[f"a{k}"], values[f"b{k}"]) for k in range(len(knots))]
    found = {}
    for name, effect in vocabulary.loads.items():
        card = bench.model.cards[effect]
        starts = [_zero(card, place)]
        if name == "resonator":
            tops = knots[np.argsort(size)[::-1][:RESONANCES]]
            starts = [_zero(card, {**place, "resonance": float(f)}) for f in tops]
        found[name] = (effect, bench.best(effect, starts))
    return found


def _zero(card: EffectCard, shapes: Values) -> dict[str, float]:
    return {name: shapes.get(name, value) for name, value in card.zero().items()}


def _form(bench: _Bench, name: str, effect: str, fit: GapFit, vocabulary: Vocabulary) -> Form:
    """Return a form with its estimates; they contain what it leaves."""
    excess = bench.base.total - bench.base.dof
    share = (bench.base.total - fit.total) / excess if excess > 0.0 else 0.0
    nats = (fit.log_evidence - bench.base.log_evidence) / bench.errors
    found = _estimated(fit, effect, vocabulary)
    return Form(name, effect, **found, nats=nats, share=float(np.clip(share, 0.0, 1.0)))


def _estimated(fit: GapFit, effect: str, vocabulary: Vocabulary) -> dict[str, Any]:
    """Values of an effect, with their standard deviations, and its curve."""
    places = [k for k, (owner, _) in enumerate(fit.free.names) if owner == effect]
    sigma, values = fit.stated.parameters[places], fit.state.effects[effect]
    cards = [fit.free.cards[k] for k in places]
    estimates = tuple(
        Estimate(card.name, values[card.name], float(s), card.unit) for card, s in zip(cards, sigma, strict=True)
    )
    curve = _curve(estimates, vocabulary.knots[effect]) if effect in vocabulary.knots else None
    return {"values": dict(values), "parameters": estimates, "curve": curve}


def _curve(estimates: Sequence[Estimate], knots: Real) -> Curve:
    known = {one.name: one for one in estimates}
    rows = [[known[f"{letter}{k}"] for k in range(len(knots))] for letter in "ab"]
    return Curve(
        knots,
        np.array([[one.value for one in row] for row in rows]),
        np.array([[one.sigma for one in row] for row in rows]),
    )


def dependences(
    model: TwinModel, sweeps: GapSweeps, fit: GapFit, effect: str, executor: Executor, errors: float
) -> tuple[Dependence, ...]:
    """Strength of an effect by temperature, ramp, level, channel and time.

    Parameters
    ----------
    model : TwinModel
    sweeps : GapSweeps
    fit : GapFit
        Of these sweeps, the effect among its own.
    effect : str
    executor : Executor
        Sweeps are linearised on it.
    errors : float
        By which chi2 is divided.

    Returns
    -------
    tuple of Dependence
        Of circumstances that have more than one value in these sweeps; none of an effect without strength.
    """
    state, card = fit.state, model.cards[effect]
    values = state.effects[effect]
    tangents: list[Tangent] = [(effect, p.name, values) for p in card.amplitudes]
    white = whiten_all(model, sweeps, state, tangents, executor)
    amounts = np.array([values[p.name] for p in card.amplitudes])
    first = len(white[0].white) - 1 - len(amounts)
    signal = np.array([np.tensordot(amounts, one.white[first:-1], 1) for one in white])
    found: list[Dependence] = []
    if not signal.any():
        return ()
    for on, labels, part in _circumstances(sweeps):
        split = [_split(one, signal[s], first, part[s]) for s, one in enumerate(white)]
        equations = [one.equations() for one in split]
        head = schur_complement(sweeps, equations, state, weight=1.0 / errors)
        left = head.without_gains()
        matrix = left.matrix + 1e-12 * np.trace(left.matrix) * np.eye(len(labels))
        covariance = np.linalg.inv(matrix)
        factor = 1.0 + covariance @ left.gradient
        found.append(Dependence(on, labels, factor, np.sqrt(np.diag(covariance))))
    return tuple(found)


def _split(one: WhitenedSweep, signal: NDArray[np.complex128], first: int, part: Real) -> WhitenedSweep:
    """Replace a sweep's columns of the effect by its signal in each part (L, K) of the data."""
    own = np.concatenate([one.white[:first], part[:, :, None] * signal, one.white[-1:]])
    return replace(one, white=own)


def _circumstances(sweeps: GapSweeps) -> Iterator[tuple[str, tuple[str, ...], Real]]:
    """Yield circumstances, their values, and which channels of which sweeps have each: (T, L, K)."""
    channels = len(sweeps.channels)
    group = sweeps.groups.of_sweep * MOST // max(len(sweeps.groups.size), MOST)
    mean = [
        sweeps.groups.reference[np.unique(sweeps.groups.of_sweep[group == k])].mean() for k in np.unique(group)
    ]
    order = np.argsort(np.argsort(sweeps.original)) * TIMES // sweeps.count
    for on, labels, of_sweep in (
        ("temperature", [f"{t:.0f} °C" for t in mean], np.unique(group, return_inverse=True)[1]),
        ("ramp", *_named(sweeps.direction)),
        ("level", *_named(sweeps.drives)),
        ("time", [f"part {k + 1} of {TIMES}" for k in range(TIMES)], order),
    ):
        if len(labels) > 1 and len(np.unique(of_sweep)) == len(labels):
            part = of_sweep[:, None] == np.arange(len(labels))
            yield on, tuple(labels), np.repeat(part[:, :, None], channels, axis=2).astype(float)
    if channels > 1:
        yield "channel", sweeps.channels, np.tile(np.eye(channels), (sweeps.count, 1, 1))


def _named(values: Sequence[str]) -> tuple[list[str], NDArray[np.int_]]:
    known = list(dict.fromkeys(values))
    return known, np.array([known.index(one) for one in values])
