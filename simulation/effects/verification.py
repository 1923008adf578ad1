"""What every effect must do, whoever wrote it: nothing at zero, and derivatives that a complex step gets right."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from analysis.local_laws import LocalLaws
from analysis.sweep_point import SweepPoint
from simulation.effects.effect import Effect
from simulation.state.plate_state import Circumstances, PlateState

COMPLEX_STEP = 1e-30
"""Times a parameter's prior sigma; nothing is subtracted, so that it may be as small as it likes."""
REAL_STEP = 1e-4
"""Times a parameter's prior sigma, for central differences."""
AGREEMENT = 1e-5
"""Of both derivatives, relative to the larger; central differences are good to 1e-8 or so."""
STEEPEST = 1e3
"""Slope at zero over the mean slope up to a third of a sigma: roots and the like have none."""

SPECTRA = ("storage", "loss", "area_mass", "area_resistance", "log_gain", "phase")
"""What of a state is given line by line."""


def verify(effect: Effect, experiment: Experiment) -> None:
    """Raise ValueError, saying what is wrong, unless an effect is fit for the search.

    At three sweeps that differ in temperature, rate and level: all amplitudes zero leave the state exactly as it
    was, whatever the shapes; the imaginary part that a complex step leaves in every number of the state is the
    derivative that central differences find; every amplitude has a slope at zero, finite everywhere and other than
    zero at one of the sweeps at least, for that is what a search sees of an effect before it tries it. What looks
    at the strain energy does so line by line, in spectra alone, and lets complex energies through.
    """
    card = effect.card(experiment)
    idle = {parameter.name for parameter in card.amplitudes}
    for circumstances, state in _trials(experiment):
        try:
            _check_absent(effect, card, state, circumstances)
            _check_derivatives(effect, card, state, circumstances)
            _check_energy(effect, card, state, circumstances)
            idle -= _slopes_at_zero(effect, card, state, circumstances)
        except (ArithmeticError, AttributeError, IndexError, LookupError, TypeError) as error:
            raise ValueError(f"apply fails: {type(error).__name__}: {error}") from error
    if idle:
        raise ValueError(
            f"{', '.join(sorted(idle))}: no slope at zero in anything of the state, at any sweep tried"
        )


def numbers(state: PlateState) -> dict[str, NDArray[Any]]:
    """All that can differ between two states, as flat arrays by attribute.

    Loads without stiffness, damping and mass, and discs that have lost nothing, are as good as none.
    """
    loads = [load for load in state.point_loads if load.stiffness or load.damping or load.mass]
    discs = [disc for disc in state.discs if disc.loss]
    flat = {
        "point_loads": [(*load.point, load.stiffness, load.damping, load.mass) for load in loads],
        "discs": [(disc.x, disc.y, disc.radius, disc.loss) for disc in discs],
        "laws": [state.laws.value, state.laws.slope, state.laws.curvature, np.full(3, state.laws.reference)],
    }
    others = {name: value for name, value in vars(state).items() if name not in flat}
    return {name: np.ravel(value) for name, value in {**others, **flat}.items()}


def interior_point(card: EffectCard, site: Mapping[str, float]) -> dict[str, float]:
    """Return values a third of a sigma into every amplitude's range, with the shapes of a site moved off it."""
    starts = card.zero(site)
    return {parameter.name: _inside(parameter, starts[parameter.name]) for parameter in card.parameters}


def _inside(parameter: Parameter, start: float) -> float:
    """Go a third of a sigma up where the range allows it, else down, at most half of the way to its end."""
    away, up, down = parameter.sigma / 3.0, parameter.high - start, start - parameter.low
    return start + min(away, 0.5 * up) if up > 0.0 else start - min(away, 0.5 * down)


def _trials(experiment: Experiment) -> list[tuple[Circumstances, PlateState]]:
    """Three sweeps of a plate whose laws are all steep."""
    low, high = experiment.protocol.band
    frequency = np.geomspace(low, high, 7)
    axis = np.array([-1.0, -0.4, 0.3, 1.0])
    xi, zeta = (grid.ravel() for grid in np.meshgrid(axis, axis))
    laws = LocalLaws(
        reference=30.0,
        value=np.array([np.log(2e9), 0.38, np.log(0.06)]),
        slope=np.array([-0.02, 0.002, -0.01]),
        curvature=np.array([1e-4, 1e-5, 1e-4]),
    )
    rate = experiment.protocol.ramp_rate / 60.0 or 0.01
    points = [SweepPoint(10.0, rate, 1.0), SweepPoint(45.0, -rate, 1.0), SweepPoint(45.0, rate, 2.0)]
    trials = []
    for point in points:
        declared = Circumstances.of(experiment, point, frequency)
        energy = point.level**2 * np.linspace(0.05, 0.9, frequency.size)
        circumstances = replace(declared, strain_energy=energy)
        trials.append((circumstances, PlateState.baseline(xi, zeta, laws, point.temperature, frequency)))
    return trials


def _check_absent(effect: Effect, card: EffectCard, state: PlateState, circumstances: Circumstances) -> None:
    before = numbers(state)
    for site in (*card.sites, {}):
        after = numbers(effect.apply(state, circumstances, card.zero(site)))
        for name, value in before.items():
            if not np.array_equal(after[name], value):
                raise ValueError(f"changes {name} although all its amplitudes are zero")


def _check_derivatives(effect: Effect, card: EffectCard, state: PlateState, circumstances: Circumstances) -> None:
    base = interior_point(card, card.sites[len(card.sites) // 2])
    for parameter in card.parameters:

        def moved(step: complex, name: str = parameter.name) -> dict[str, NDArray[Any]]:
            return numbers(effect.apply(state, circumstances, {**base, name: base[name] + step}))

        tiny, small = COMPLEX_STEP * parameter.sigma, REAL_STEP * parameter.sigma
        stepped, above, below = moved(1j * tiny), moved(small), moved(-small)
        for name, value in stepped.items():
            if not all(np.isfinite(those).all() for those in (value, above[name], below[name])):
                raise ValueError(f"{parameter.name}: {name} is not finite near {base}")
            exact = np.imag(value) / tiny
            central = np.real(above[name] - below[name]) / (2.0 * small)
            scale = max(_largest(exact), _largest(central))
            if _largest(exact - central) > AGREEMENT * scale + 1e-12 * _largest(np.real(value)) / small:
                raise ValueError(
                    f"{parameter.name}: a complex step in it does not give the slope of {name}; "
                    "abs, float, real, comparisons and the math module lose the imaginary part"
                )


def _check_energy(effect: Effect, card: EffectCard, state: PlateState, circumstances: Circumstances) -> None:
    """Step the energy of one line: nothing but that line of spectra may change, and by the right slope."""
    if not effect.needs_strain_energy:
        return
    at, line = interior_point(card, card.sites[len(card.sites) // 2]), circumstances.frequency.size // 2

    def moved(step: complex) -> dict[str, NDArray[Any]]:
        energy = circumstances.strain_energy + step * np.eye(circumstances.frequency.size)[line]
        return numbers(effect.apply(state, replace(circumstances, strain_energy=energy), at))

    stepped, above, below = moved(1j * COMPLEX_STEP), moved(REAL_STEP), moved(-REAL_STEP)
    for name, value in stepped.items():
        exact = np.imag(value) / COMPLEX_STEP
        central = np.real(above[name] - below[name]) / (2.0 * REAL_STEP)
        scale = max(_largest(exact), _largest(central))
        if _largest(exact - central) > AGREEMENT * scale + 1e-12 * _largest(np.real(value)) / REAL_STEP:
            raise ValueError(f"a complex step in strain_energy does not give the slope of {name}")
        elsewhere = exact != 0.0
        if name in SPECTRA:
            elsewhere[line] = False
        if elsewhere.any():
            raise ValueError(
                f"{name} follows the strain energy of another line; each line of "
                f"{', '.join(SPECTRA)} may follow its own, and nothing else"
            )


def _slopes_at_zero(effect: Effect, card: EffectCard, state: PlateState, circumstances: Circumstances) -> set[str]:
    """Return the amplitudes that move something at zero; ValueError for one that has no finite slope there."""
    zero, alive = card.zero(card.sites[len(card.sites) // 2]), set()
    for parameter in card.amplitudes:
        tiny, away = COMPLEX_STEP * parameter.sigma, _inside(parameter, 0.0)
        near = numbers(effect.apply(state, circumstances, {**zero, parameter.name: 1j * tiny}))
        far = numbers(effect.apply(state, circumstances, {**zero, parameter.name: away}))
        for name, value in near.items():
            slope = _largest(np.imag(value)) / tiny
            mean = _largest(far[name] - np.real(value)) / abs(away)
            if not slope <= STEEPEST * mean + 1e-12 * _largest(np.real(value)) / abs(away):
                raise ValueError(f"{parameter.name}: the slope of {name} is not finite at zero")
            if slope > 0.0:
                alive.add(parameter.name)
    return alive


def _largest(values: NDArray[Any]) -> float:
    return float(np.abs(values).max(initial=0.0))
