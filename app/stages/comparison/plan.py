"""Plan stage: which measurement would settle what a comparison left open; what it was, once it is made."""

from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from analysis.forked import ForkedExecutor
from analysis.gap.data.preparation import prepare
from analysis.gap.data.sweeps import GapSweeps
from analysis.gap.fitting.fit import fit_gap
from analysis.gap.fitting.state import starting_state
from analysis.gap.plan.decision import Decision, Expected, Plan, decided, ranked, told, weights
from analysis.gap.plan.measurement import (
    OVEN_FIXED,
    Measurement,
    Reach,
    campaigns,
    hand_tools,
    placed,
    planned_sweeps,
    with_noise_of,
)
from analysis.gap.plan.separation import Information, LinearisedCampaign, Question, open_questions, separation
from analysis.gap.report import GapReport
from analysis.progress import Progress
from analysis.recordings.frf_campaign import AnyCampaign
from analysis.twin_model import NO_EFFECTS, Effects, HeldEffects
from analysis.updating.drift import to_first_order
from app.files.bad_file import ResultFileError
from app.files.campaign_error import CampaignFileError
from app.files.campaigns.of_run import campaign_of
from app.files.parsed_text import parse_json, read_text
from app.stages.comparison.compared import Compared
from app.stages.update import updated_twin
from app.twins.campaign_twin import (
    KNOWN_MASS,
    campaign_model,
    judging,
    known_mass,
    with_sensors,
)
from simulation.twin.effect_plate import EffectPlate
from simulation.twin.twin import Twin

TURNED = "turned_plate"
LARGEST_GAP_FILE = 50_000_000
"""Bytes of a gap.json that is read."""


def open_before(run: Path) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Read from a run what its plan left open.

    Parameters
    ----------
    run : Path
        Run folder with a gap.json of ``flexura gap --plan``.

    Returns
    -------
    effects : tuple of str
        All that its questions are about.
    turned : tuple of str
        Those whose amplitudes change sign, where the plan was to turn the plate.

    Raises
    ------
    ResultFileError
        Where there is none, or nothing was open.
    """
    file = run / "gap.json"
    try:
        record: Mapping[str, Any] = parse_json(read_text(file, LARGEST_GAP_FILE))
        plan = record["plan"]
        names = [name for one in plan["questions"] for name in (one["effect"], one["rival"]) if name]
        chosen = plan["next"] or {}
    except (OSError, CampaignFileError, ValueError, KeyError, TypeError) as error:
        wanted = f"make it with: flexura gap {campaign_of(run)} --plan"
        raise ResultFileError(f"{file}: holds no plan; {wanted}") from error
    if not names:
        raise ResultFileError(f"{file}: its plan has no questions; nothing was open that could be decided")
    turned = OVEN_FIXED if chosen.get("key") == TURNED else ()
    return tuple(dict.fromkeys(str(name) for name in names)), turned


def next_experiment(
    compared: Compared,
    found: GapReport,
    report: Progress,
    hours: Mapping[str, float] | None = None,
    reach: Reach | None = None,
) -> Plan:
    """Rank the measurements that could settle what a comparison left open.

    Parameters
    ----------
    report : callable
        Called with a stage's name and the share of it done.
    hours : mapping of str to float, optional
        Of some kinds of measurement, instead of the usual ones.
    reach : Reach, optional
        Of the rig.

    Returns
    -------
    Plan
        Without questions where nothing is open.
    """
    questions = open_questions(found, tuple(compared.model.cards))
    with ForkedExecutor() as executor:
        return plan(compared, questions, report, executor, hours or {}, reach)


def plan(
    compared: Compared,
    questions: Sequence[Question],
    report: Progress,
    executor: Executor,
    hours: Mapping[str, float],
    reach: Reach | None = None,
) -> Plan:
    """Rank the measurements for some questions.

    Parameters
    ----------
    report : callable
        Called with a stage's name and the share of it done.
    executor : Executor
        Sweeps are linearised on it.
    hours : mapping of str to float
        Of some kinds of measurement, instead of the usual ones.
    reach : Reach, optional
        Of the rig.
    """
    if not questions:
        return Plan((), ())
    report("plan", 0.0)
    asked = tuple(dict.fromkeys(name for question in questions for name in question.effects))
    here = LinearisedCampaign.at(
        compared.model, compared.sweeps, compared.fit.state, compared.fit, asked, executor
    )
    recorded = here.information()
    before = _separations(questions, recorded, recorded)
    found, notes, counted = [], [], weights(questions)
    for tool in hand_tools(compared.experiment):
        after = _separations(questions, here.information(sharper=tool.sharper), recorded, tool.readings)
        found.append(Expected(tool, before, after, counted))
    wanted = list(_campaigns(compared, questions, reach))
    for done, group in enumerate(wanted):
        report("plan", (done + 1) / (len(wanted) + 1))
        try:
            told = _simulated(compared, group, asked, executor)
        except np.linalg.LinAlgError:  # a ValueError, and a defect
            raise
        except ValueError as error:
            notes.append(f"{group[0].key}: not simulated: {error}")
            continue
        for one, information in zip(group, told, strict=True):
            both = recorded.beside(information.turned(one.turned))
            found.append(Expected(one, before, _separations(questions, both, recorded, one.readings), counted))
    timed = [replace(one, measurement=_timed(one.measurement, hours)) for one in found]
    report("plan", 1.0)
    return ranked(questions, timed, notes)


def _campaigns(
    compared: Compared, questions: Sequence[Question], reach: Reach | None
) -> Iterator[list[Measurement]]:
    """Campaigns worth a simulation; those with a further sensor together, because one linearisation serves all."""
    asked = {name for question in questions for name in question.effects}
    for one in campaigns(compared.experiment, reach):
        if not one.turned or asked & set(one.turned):
            yield [one]
    at_places = placed(compared.experiment)
    sensors = [one for one in at_places if not one.mass]
    if sensors:
        yield sensors
    if KNOWN_MASS["effect"] not in asked | set(compared.fit.state.effects) | set(compared.model.held):
        yield from ([one] for one in at_places if one.mass)


def _simulated(
    compared: Compared, group: Sequence[Measurement], asked: Sequence[str], executor: Executor
) -> list[Information]:
    """Information that campaigns of the same sweeps would add, one for each."""
    first, model = group[0], compared.model
    if first.experiment is None:
        raise ValueError("no campaign")
    further = 0
    twin = compared.twin
    if first.mass and first.place is not None:
        model = replace(model, held={**model.held, **known_mass(first.place, first.mass)})
    elif first.place is not None:
        further = len(group)
        twin = with_sensors(twin, [one.place for one in group if one.place is not None])
        model = replace(model, twin=twin)
    protocol = first.experiment.protocol
    if protocol.band[1] > twin.band[1]:
        twin = _over(twin, protocol.band)
        model = replace(model, twin=twin)
    sweeps, state = planned_sweeps(compared.frf, compared.sweeps, compared.fit.state, protocol, model.box, further)
    if further:
        sweeps = with_noise_of(sweeps, _sizes(model, sweeps, state, executor), further)
    state = state.with_tolerances(model.tolerance_cards)
    there = LinearisedCampaign.at(model, sweeps, state, compared.fit, asked, executor)
    own = list(range(len(compared.frf.channels)))
    if not further:
        return [there.information()]
    return [there.information([*own, len(own) + k]) for k in range(further)]


def _sizes(model: HeldEffects, sweeps: GapSweeps, state: Any, executor: Executor) -> list[float]:
    """Rms of every output over all sweeps."""
    laws = sweeps.smoothness.laws(state.laws)
    model = model.counted(laws, state.on)

    def one(sweep: int) -> Any:
        point = state.circumstances(sweep, sweeps.points[sweep])
        return model.frf(laws[sweeps.groups.of_sweep[sweep]], sweeps.nodes.frequency, state.on, point)

    answers = np.array(list(executor.map(one, range(sweeps.count))))
    return [float(size) for size in np.sqrt((np.abs(answers) ** 2).mean(axis=(0, 2)))]


def _over(twin: Twin[EffectPlate], band: tuple[float, float]) -> Twin[EffectPlate]:
    """Return a twin that answers in a wider band, where its plate is less exact: a plan needs no more."""
    operators = replace(twin.plate.operators, band=band)
    return replace(twin, plate=EffectPlate(operators))


def _separations(
    questions: Sequence[Question],
    information: Information,
    recorded: Information,
    readings: Mapping[tuple[str, str], float] | None = None,
) -> tuple[float, ...]:
    return tuple(separation(one, information, readings or {}, recorded) for one in questions)


def _timed(one: Measurement, hours: Mapping[str, float]) -> Measurement:
    return replace(one, hours=hours[one.key]) if one.key in hours else one


def compared_plainly(
    campaign: AnyCampaign, mains: float, report: Progress, executor: Executor, held: Effects = NO_EFFECTS
) -> Compared:
    """Fit the twin without effects to a campaign.

    Parameters
    ----------
    mains : float
        Hz.
    report : callable
        Called with a stage's name and the share of it done.
    executor : Executor
        Sweeps are linearised on it.
    held : mapping, optional
        Effects that are known to be there, such as a known mass.
    """
    plain = updated_twin(campaign, mains, report)
    twin, _ = campaign_model(campaign.experiment, plain.updated, report, None, None)
    model, protocol = HeldEffects(twin, held), campaign.experiment.protocol
    steady = to_first_order(plain.frf, model, plain.local_laws, plain.updated.gains, protocol, executor)
    sweeps, _ = prepare(steady, protocol, plain.updated)
    fit = fit_gap(model, sweeps, starting_state(plain.updated, sweeps.groups), (), executor)
    return Compared(campaign.experiment, steady, twin, model, sweeps, fit)


def answer(
    campaigns: Sequence[Compared], effects: Sequence[str], turned: Sequence[str], executor: Executor
) -> Decision:
    """Decide between some effects, and none of them, by one or two campaigns.

    Parameters
    ----------
    campaigns : sequence of Compared
        The recorded one, then the planned one.
    effects : sequence of str
        Those that a campaign's twin does not know are left out.
    turned : sequence of str
        Effects whose amplitudes have the other sign in the second.
    executor : Executor
        Sweeps are linearised on it.
    """
    known = [name for name in effects if all(name in one.model.cards for one in campaigns)]
    said = [told(one.model, one.sweeps, one.fit.state, known, executor) for one in campaigns]
    return decided(said[0], said[1] if len(said) > 1 else (), turned)


def with_answer(earlier: AnyCampaign, run: Path, now: Compared, mains: float, report: Progress) -> Decision:
    """Decide what an earlier comparison left open, with the campaign that was compared now.

    Parameters
    ----------
    run : Path
        Run folder of its comparison, with a plan.
    mains : float
        Hz.
    report : callable
        Called with a stage's name and the share of it done.

    Returns
    -------
    Decision

    Raises
    ------
    ResultFileError
        As `open_before`, and for a campaign that cannot be judged.
    """
    effects, turned = open_before(run)
    with ForkedExecutor() as executor, judging(earlier):
        report("earlier campaign", 0.0)
        before = compared_plainly(earlier, mains, report, executor)
        report("answer", 0.0)
        decision = answer([before, now], effects, turned, executor)
        report("answer", 1.0)
    return decision
