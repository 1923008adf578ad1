"""Model updating of a campaign: E, nu, eta of every sweep and one gain over all of them, or one per input.

The misfit is the paper's eq. (12), each line weighted by its variance. The estimates are those of
`analysis.gap.fitting.fit` with no effects, every sweep with laws of its own. Start values are found here: every
sweep is fitted alone on few lines, gain included, outwards from a middle sweep so that each starts from its
neighbour, input by input; then the gains of an input are averaged into one. Where the twin of a plate with
tolerances leaves clearly more than noise, the fit is repeated beside the scatter of resonances
(`analysis.gap.imperfect`).

Inverted channels, recorded with the wrong sign: leads swapped, or a patch mounted or poled the wrong way.
"""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from analysis.effect_card import Values
from analysis.estimates import LOSS, MODULI, TRANSVERSE
from analysis.experiment import Protocol
from analysis.forked import ForkedExecutor
from analysis.gap.data.noise import NoiseCheck
from analysis.gap.data.preparation import apart
from analysis.gap.data.sweeps import GapSweeps
from analysis.gap.fitting.gap_fit import GapFit, fitted_sheet, sweep_powers
from analysis.gap.fitting.state import GapState
from analysis.gap.imperfect.search import over_all_sweeps, settled_from_first_order
from analysis.gap.search.context import SearchContext
from analysis.material import LocalLaws, Material, MaterialBox, MaterialSigma, Orthotropy
from analysis.progress import Progress
from analysis.recordings.frf import Frf
from analysis.twin_model import Remade, TwinModel
from analysis.updated import Updated
from analysis.updating.drift import sweep_laws, to_first_order
from analysis.updating.laws import laws_of_sweeps
from analysis.updating.normal_equations import SweepData, SweepFit, fit_sweep, moved
from analysis.updating.start import in_phase, start_material

LINES_OF_THE_WALK = 500
"""Lines used while sweeps are fitted alone, if modes are many lines wide; the final fit uses all."""
LINES_OF_A_MODE = 2.0
"""Fewest lines within a resonance's half-power width, at the middle of the box's loss factors."""
OFF_THE_TREND = 3.0
"""A misfit this many times the neighbour's is taken for a wrong minimum: the sweep starts from the grid."""
CLEARLY = 1.5
"""chi2 per number, beyond the twin's own error, above which a fit leaves what is not noise: then the scatter of
resonances is a part of the model, or the stated deviations would be those of a twin that lacks nothing."""


def update(
    frf: Frf,
    model: TwinModel,
    *,
    tolerant: TwinModel | None = None,
    begin: NDArray[np.float64] | None = None,
    sheet: Orthotropy | None = None,
    declared: Mapping[str, Values] | None = None,
    protocol: Protocol | None = None,
    nearer: Remade | None = None,
    progress: Progress | None = None,
) -> Updated:
    """Fit the model's material to every sweep of `frf`, with one gain over all sweeps of an input.

    Parameters
    ----------
    frf : Frf
        Measured; lines in `frf.excluded` take no part.
    model : TwinModel
        The twin, evaluated inside its box only.
    tolerant : TwinModel, optional
        The same twin for the joint fit, with tolerances of what is declared; `model` by default.
    begin : (3,) ndarray, optional
        E, nu and eta near those of `middle_sweep`; else the start grid finds them.
    sheet : Orthotropy, optional
        Declared one of an orthotropic sheet: constants by direction are estimated.
    declared : mapping, optional
        Values of declared quantities at which the joint fit starts, and which `model` holds.
    protocol : Protocol, optional
        Tells the drift of the temperature, which the model then follows in the joint fit, with the slopes of laws
        through the fits of single sweeps. Else each sweep counts as measured at one temperature.
    nearer : callable, optional
        Asked with the values of declared quantities that a fit to a few temperatures found: gives the twin made
        about these, with which to go on, or None where `tolerant` is as exact.
    progress : callable, optional
        Called with a stage's name and the share of it done.

    Raises
    ------
    ValueError
        Where lines have no variance, so that they cannot be weighted.
    """
    frf.require_noise()
    report = progress or (lambda stage, share: None)
    coarse = [SweepData.of(frf, t, stride(frf, model.box)) for t in range(len(frf.temperature))]
    if begin is None:
        begin = start_material(model, coarse[middle_sweep(frf)], lambda share: report("start grid", share))
    with ForkedExecutor() as pool:
        alone = _fitted_alone(frf, model, coarse, begin, report, pool)
        report("common gain", 0.0)
        start = tied(model.box, alone, frf.driven_by)
        if protocol is not None:
            laws = _laws_alone(frf, alone, protocol)
            frf = to_first_order(frf, model, laws, np.exp(start.log_gain), protocol, pool)
            start = replace(start, tilt=np.array([law.slope for law in laws]))
        start = start.with_declared(declared or {})
        sweeps = apart(frf, _sharpest(material_of(alone), declared or {}), protocol)
        joint = model if tolerant is None else tolerant
        context = SearchContext(joint, sweeps, NoiseCheck.as_stated(sweeps.compressed), pool)
        if not joint.tolerance_cards:
            fit = context.fit(start, ())
        else:
            fit, joint = _fitted(context, start, nearer or (lambda _: None), report)
    report("common gain", 1.0)
    return _summary(frf, joint, sweeps, fit, alone, sheet)


def _fitted(
    context: SearchContext,
    start: GapState,
    nearer: Remade,
    report: Progress,
) -> tuple[GapFit, TwinModel]:
    """Fit all sweeps within the tolerances, a few temperatures first; beside what is missing, if that is much."""
    few, part = context.at_few_temperatures(start)
    begun = few.fit(part, ())
    if not _lacks_something(few.sweeps, begun):
        better = nearer(begun.state.declared)
        if better is not None:
            context, few = context.seen_by(better), few.seen_by(better)
            begun = few.fit(begun.state, ())
        return context.fit(context.spread(start, few, begun.state), ()), context.model
    report("beside what is missing", 0.0)
    return over_all_sweeps(context, start, settled_from_first_order(few, begun)), context.model


def _lacks_something(sweeps: GapSweeps, fit: GapFit) -> bool:
    """Whether a fit leaves clearly more than noise and the twin's own numerical error."""
    return float(fit.chi2.sum()) - sweeps.allowed > CLEARLY * sweeps.numbers


def _fitted_alone(
    frf: Frf,
    model: TwinModel,
    data: Sequence[SweepData],
    begin: NDArray[np.float64],
    report: Progress,
    executor: Executor,
) -> list[SweepFit]:
    """Fit each sweep alone, outwards from the middle one of every input; the first begins at `begin` (3,)."""
    fits: dict[int, SweepFit] = {}

    def advance() -> None:
        report("sweeps", len(fits) / len(data))

    for source in frf.driving:
        order = by_temperature(frf, source)
        middle = len(order) // 2
        if fits:  # the plate is the same whichever input drives it
            nearest = min(fits, key=lambda t: abs(frf.temperature[t] - frf.temperature[order[middle]]))
            begin = fits[nearest].material
        fits[order[middle]] = fit_sweep(model, data[order[middle]], begin)
        ways = (order[middle:], order[middle::-1])
        for walk in [executor.submit(_walk, model, data, way, fits, advance) for way in ways]:
            walk.result()
    return [fits[t] for t in range(len(data))]


def material_of(fits: Sequence[SweepFit]) -> Material:
    """Materials (T,) to which sweeps were fitted."""
    return Material(*np.array([fit.material for fit in fits]).T)


def tied(box: MaterialBox, fits: Sequence[SweepFit], source: NDArray[np.int_]) -> GapState:
    """Return the state with one gain for all sweeps of an input: their mean, weighted by information.

    Each sweep's material is adjusted to it.

    Parameters
    ----------
    box : MaterialBox
        Within which materials stay.
    source : (T,) int ndarray
        Which input drove each sweep.
    """
    # to first order, without another evaluation: a settled sweep's last step has not been taken yet
    points = [fit.point for fit in fits]
    information = np.array([1.0 / np.linalg.inv(p.matrix)[3, 3] for p in points])
    log_gains = np.array([fit.log_gain for fit in fits])
    weight = np.maximum(np.bincount(source, information), np.finfo(float).tiny)
    log_gain = np.bincount(source, information * log_gains) / weight
    rows = [
        box.clip(moved(p.material, p.following(float(log_gain[one] - np.log(p.gain)))))
        for p, one in zip(points, source, strict=True)
    ]
    laws = np.array([[np.log(e), nu, np.log(eta)] for e, nu, eta in rows])
    straight = np.zeros_like(laws)
    return GapState(laws, straight, straight, np.zeros(len(rows)), log_gain, {})


def _laws_alone(frf: Frf, alone: Sequence[SweepFit], protocol: Protocol) -> list[LocalLaws]:
    """Laws near every sweep by the fits of single sweeps, with the slopes of smooth laws through them."""
    settled = np.array([fit.settled for fit in alone])
    material = material_of(alone)
    laws = laws_of_sweeps(frf.temperature, material, _sigma_of(alone), settled, protocol)
    return sweep_laws(frf.temperature, material, laws)


def _sigma_of(fits: Sequence[SweepFit]) -> MaterialSigma:
    """Return the standard deviations (T,) of the materials, by the noise."""
    laws = np.sqrt([np.diag(np.linalg.inv(fit.point.matrix))[:3] for fit in fits])
    return material_of(fits).sigma(laws)


def middle_sweep(frf: Frf) -> int:
    """Return the sweep of the first input at which the updating starts."""
    first = by_temperature(frf, int(frf.driven_by.min()))
    return first[len(first) // 2]


def by_temperature(frf: Frf, source: int) -> list[int]:
    """Return the sweeps that an input drove, coldest first."""
    order = np.argsort(frf.temperature, kind="stable")
    return [int(t) for t in order[frf.driven_by[order] == source]]


def stride(frf: Frf, box: MaterialBox) -> int:
    """Return the stride between the lines used in fits of single sweeps."""
    lines = frf.frequency
    width = float(np.sqrt(np.prod(box.loss_factor)) * np.sqrt(lines[0] * lines[-1]))
    enough = width / (LINES_OF_A_MODE * float(lines[1] - lines[0]))
    return max(1, min(len(lines) // LINES_OF_THE_WALK, int(enough)))


def _walk(
    model: TwinModel,
    data: Sequence[SweepData],
    way: Sequence[int],
    fits: dict[int, SweepFit],
    advance: Callable[[], None],
) -> None:
    """Fit sweeps along `way`, whose first is fitted; each starts from values extrapolated from its neighbours."""
    trend = np.ones(3)
    for before, sweep in pairwise(way):
        known = fits[before]
        fit = fit_sweep(model, data[sweep], known.material * trend)
        if not fit.settled or fit.misfit > OFF_THE_TREND * known.misfit:
            again = fit_sweep(model, data[sweep], start_material(model, data[sweep]))
            fit = min(fit, again, key=lambda f: f.misfit)
        fits[sweep] = fit
        trend = np.clip(fit.material / known.material, 0.8, 1.25)
        advance()


def _sharpest(material: Material, declared: Mapping[str, Values]) -> Material:
    """Return materials with the least loss factor of a sheet's directions."""
    loss = declared.get(LOSS)
    if loss is None:
        return material
    least = min(-0.5 * abs(loss["ratio"]), loss["shear"])
    return replace(material, loss_factor=np.exp(least) * material.loss_factor)


def _summary(
    frf: Frf,
    model: TwinModel,
    sweeps: GapSweeps,
    fit: GapFit,
    fits: Sequence[SweepFit],
    sheet: Orthotropy | None,
) -> Updated:
    """Collect the fitted sweeps into one value."""
    laws = fit.state.laws
    materials = np.stack([np.exp(laws[:, 0]), laws[:, 1], np.exp(laws[:, 2])], axis=1)
    covariance = np.linalg.inv(fit.alone)
    spread = np.sqrt(np.diagonal(covariance, axis1=1, axis2=2))
    within = np.array([sweep.chi2_within.sum() for sweep in sweeps.compressed])
    chi2_per_dof = (fit.chi2.sum(axis=1) + within) / (2 * sweeps.nodes.lines.size * len(frf.channels) - 4)
    # with one gain per input, a sweep's material has its own noise and a share of the gain's
    own = np.maximum(fit.noise.laws**2 - (fit.noise.common**2).sum(axis=2), 0.0)
    own *= np.maximum(chi2_per_dof, 1.0)[:, None]
    common = _common(fit, own)
    sigma = np.sqrt(own + (common**2).sum(axis=2))
    missed, power = sweep_powers(sweeps, fit)
    within_reach = not {MODULI, LOSS, TRANSVERSE} & {name for name, _ in fit.on_wall}
    several = len(fit.state.log_gain) > 1
    means = [chi2_per_dof[frf.driven_by == one].mean() for one in range(len(fit.state.log_gain))]
    gain = np.exp(fit.state.log_gain)
    by_noise = fit.noise.log_gain * np.sqrt(np.maximum(means, 1.0))
    gains = np.stack([gain, gain * (fit.stated.log_gain if common.size else by_noise)], axis=1)
    return Updated(
        temperature=frf.temperature,
        material=Material(*materials.T),
        sigma=Material(*materials.T).sigma(sigma),
        correlation=covariance / (spread[:, :, None] * spread[:, None, :]),
        gain=float(gains[0, 0]),
        sigma_gain=float(gains[0, 1]),
        misfit_start=np.array([f.misfit_start for f in fits]),
        misfit=np.sqrt(missed / power),
        noise_floor=frf.noise_floor,
        chi2_per_dof=chi2_per_dof,
        settled=np.array([f.settled for f in fits]) & model.box.inside(materials) & within_reach,
        further=gains[1:] if several else None,
        declared=fit.declared_quantities(model.tolerance_cards),
        common=common if common.size else None,
        sheet=fitted_sheet(sheet, fit, sigma, own),
    )


def _common(fit: GapFit, own: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return `Updated.common` of a fit whose sweeps have variances `own` (T, 3) by their noise.

    The twin's own error is common to all sweeps, as those of the declaration are. Without tolerances it is left
    out: the twin is then taken as exact.
    """
    declared = fit.stated.common
    if not declared.size:
        return declared
    twin = np.sqrt(np.maximum(fit.stated.laws**2 - (declared**2).sum(axis=2) - own, 0.0))
    return np.concatenate([declared, twin[:, :, None]], axis=2)


NEAR = 6.0
"""Largest temperature difference of neighbours, K: a model error shows in all sweeps within it."""
LEAST_NEIGHBOURS = 2
FAR_WORSE = 10.0
"""Ratio of chi2 to that of every neighbour from which a sweep is an outlier: effects vary smoothly."""


def outlier_sweeps(frf: Frf, updated: Updated) -> list[int]:
    """Return the sweeps whose misfit, with a material of their own, far exceeds that of all their neighbours.

    Neighbours are sweeps of one input at one level within `NEAR`; a sweep with fewer than two is not judged.
    """
    chi2 = np.maximum(updated.chi2_per_dof, 1.0)
    outliers = []
    for sweep in range(len(chi2)):
        near = (np.abs(frf.temperature - frf.temperature[sweep]) <= NEAR) & (frf.level == frf.level[sweep])
        near &= frf.driven_by == frf.driven_by[sweep]
        near[sweep] = False
        if near.sum() >= LEAST_NEIGHBOURS and chi2[sweep] > FAR_WORSE * chi2[near].max():
            outliers.append(sweep)
    return outliers


AGREES = 0.5
"""Correlation of twin and data above which a channel's sign is certain; unrelated responses have about 0."""


def polarity_corrected(
    frf: Frf, model: TwinModel, progress: Callable[[str, float], None] = lambda stage, share: None
) -> tuple[Frf, NDArray[np.float64]]:
    """Correct the sign of inverted channels.

    No material changes the sign of a whole FRF, so a twin does not agree with an inverted channel. If a fit does
    not agree with every channel, the start grid is searched again with the better sign for each channel; if the
    result agrees with every channel, these signs are right.

    Parameters
    ----------
    frf : Frf
        As measured.
    model : TwinModel
        The twin, evaluated inside its box only.
    progress : callable, optional
        Called with a stage's name and the share of it done.

    Returns
    -------
    frf : Frf
        With a note for each inverted channel.
    start : (3,) ndarray
        E [Pa], nu and eta of the middle sweep of the first input.

    Raises
    ------
    ValueError
        Where lines have no variance, so that they cannot be weighted.
    """
    frf.require_noise()
    begins = []
    for source in frf.driving:
        names, begin = _inverted(frf.of_source(source), model, progress)
        begins.append(begin)
        frf = frf.turned(names, source)
    return frf, begins[0]


def _inverted(
    frf: Frf, model: TwinModel, progress: Callable[[str, float], None]
) -> tuple[list[str], NDArray[np.float64]]:
    """Names of the channels inverted in one input's sweeps, and the material (3,) of its middle sweep."""
    data = SweepData.of(frf, middle_sweep(frf), stride(frf, model.box))
    begin = start_material(model, data, lambda share: progress("start grid", share))
    if _explained(model, data, begin):
        return [], begin
    other = start_material(model, data, lambda share: progress("start grid, any signs", share), signed=False)
    inverted = in_phase(data.answer(model, other), data) < 0.0
    sign = np.where(inverted, -1.0, 1.0)[:, None]
    if inverted.any() and _explained(model, replace(data, h=sign * data.h), other):
        return [name for name, wrong in zip(frf.channels, inverted, strict=True) if wrong], other
    return [], begin


def _explained(model: TwinModel, data: SweepData, begin: NDArray[np.float64]) -> bool:
    """Whether a fit started at the material `begin` (3,) agrees with every channel."""
    return bool((in_phase(data.answer(model, begin), data) > AGREES).all())
