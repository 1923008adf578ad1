"""Trial of planned experiments: a question left open, the plan for it, the planned measurement, and the answer.

    python -m app.blind_trial.planned --count 50 --seed 1 --out FOLDER

In each trial a plate hides one effect in a campaign that cannot show it, or not tell it from another one. The
measurement that is planned is then made on the simulated rig, from the experiment's file that the plan wrote, or
read by hand with the stated standard deviation. The trial is right if both campaigns together settle the name, and
it is the hidden one. Every trial writes one JSON file; what is there is not made again.
"""

import argparse
from collections.abc import Mapping, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from analysis.effect_card import Values
from analysis.gap.fitting.fit import fit_gap
from analysis.gap.plan.decision import NOTHING, Plan, Told, decided, told
from analysis.gap.plan.measurement import Measurement
from analysis.gap.plan.separation import ENOUGH, Question
from app.blind_trial.draw_effects import of_size
from app.blind_trial.effect_size import EffectSize
from app.blind_trial.experiments import any_declaration, draw_experiments
from app.blind_trial.outcome import read_record
from app.blind_trial.plates import PlateKind, draw_plate
from app.blind_trial.specimen import Specimen, specimen_operators
from app.files.atomic import write_json
from app.files.campaigns.folder import Source
from app.files.campaigns.loading import load_campaign
from app.files.declarations.experiment import AcquiredExperiment, read_acquired_experiment
from app.files.provenance import sha256
from app.files.results.next_experiment import NAME, reach_of, write_next_experiment
from app.stages.acquire import acquire_campaign
from app.stages.comparison.compared import Compared
from app.stages.comparison.plan import compared_plainly, plan
from app.twins.campaign_twin import effect_twin, known_mass
from drivers.rig.campaign import unobserved
from drivers.rig.session import Session


@dataclass(frozen=True)
class HiddenCase:
    """A hidden effect, and what it is not told from in one campaign.

    Attributes
    ----------
    effect : str
    rivals : tuple of str
    blind : bool
        Whether one ramp at one level shows none of them.
    """

    effect: str
    rivals: tuple[str, ...]
    blind: bool = False

    @property
    def effects(self) -> tuple[str, ...]:
        """Return all of them, the hidden one first."""
        return (self.effect, *self.rivals)


CASES = (
    HiddenCase("thermal_lag", ("annealing", "depolarization"), blind=True),
    HiddenCase("draught_gradient", ("thickness_taper", "modulus_gradient")),
    HiddenCase("amplitude_softening", ("piezo_nonlinearity",), blind=True),
    HiddenCase("thickness_taper", ("draught_gradient", "density_gradient")),
    HiddenCase("annealing", ("thermal_lag", "depolarization"), blind=True),
    HiddenCase("viscoelastic_dispersion", ("air_loading",)),
    HiddenCase("density_gradient", ("thickness_taper", "draught_gradient")),
    HiddenCase("piezo_nonlinearity", ("amplitude_softening",), blind=True),
    HiddenCase("modulus_gradient", ("draught_gradient", "thickness_taper")),
    HiddenCase("air_loading", ("viscoelastic_dispersion",)),
)
"""Used in turn."""
LINE_NOISE = 0.015
"""Of a line, as a share of the response."""
SIZE = (10.0, 30.0)
"""Of effects that are seen, sigma: larger ones are told apart at once."""
TRIALS_ON_A_PLATE = 10
"""Trials on one plate."""
SILENT = lambda stage, share: None  # noqa: E731 (a callable without a body)


def main() -> None:
    """Run the trials of the command line, and print how many were right."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=10, help="number of trials")
    parser.add_argument("--seed", type=int, default=1, help="of all random numbers")
    parser.add_argument("--out", type=Path, required=True, help="folder of the results")
    given = parser.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    found = []
    for number in range(given.count):
        file = given.out / f"{number:04d}.json"
        if not file.is_file():
            write_json(file, one_trial(number, given.seed, given.out / f"{number:04d}"))
        found.append(read_record(file))
        print(summary(found), flush=True)


def summary(found: Sequence[Mapping[str, Any]]) -> str:
    """Return one line: how many questions were open, and how many were settled, rightly and wrongly."""
    opened = [one for one in found if one["open"]]
    right = sum(one["settled"] == one["hidden"] for one in opened)
    wrong = sum(one["settled"] not in (None, one["hidden"]) for one in opened)
    return f"{len(found)} trials, {len(opened)} open: {right} settled rightly, {wrong} wrongly; {dict(found[-1])}"


def one_trial(number: int, seed: int, folder: Path) -> dict[str, Any]:
    """Hide an effect, plan, measure, decide.

    Parameters
    ----------
    number, seed : int
    folder : Path
        Where the campaigns go.

    Returns
    -------
    dict
        What was hidden, planned and settled.
    """
    rng, case = np.random.default_rng([seed, number]), CASES[number % len(CASES)]
    kind = draw_plate(np.random.default_rng([seed, 10**6, number // TRIALS_ON_A_PLATE]))
    experiment = draw_experiments(rng, kind, f"planned {number}", ("up",), (1.0,))[0]
    specimen = Specimen.of([experiment], specimen_operators(any_declaration(kind)))
    with ThreadPoolExecutor(1) as executor:
        hidden, noise = _hidden(specimen, kind, case, rng, executor)
        first = _recorded(specimen, experiment, hidden, noise, folder / "first")
        compared = _compared(first, {}, executor)
        seen = told(compared.model, compared.sweeps, compared.fit.state, case.effects, executor)
        compared, questions = _questions(compared, case, seen, executor)
        planned = plan(compared, questions, SILENT, executor, {}, reach_of(experiment))
        before = planned.ranked[0].before
        chosen, record = planned.winner, {"number": number, "hidden": case.effect, "values": hidden}
        record |= {"open": min(before) < ENOUGH, "before_sigma": list(before), "notes": list(planned.notes)}
        if chosen is None or not record["open"]:
            return record | {"planned": None, "settled": decided(seen).settled, "nats": {}}
        decision = _measured(
            planned, chosen.measurement, experiment, hidden, noise, seen, case, folder, rng, executor
        )
    return record | {
        "planned": chosen.measurement.words,
        "after_sigma": list(chosen.after),
        "settled": decision.settled,
        "nats": dict(decision.nats),
    }


def _hidden(
    specimen: Specimen, kind: PlateKind, case: HiddenCase, rng: np.random.Generator, executor: Executor
) -> tuple[dict[str, Values], float]:
    """Draw the values of the hidden effect, and the noise, V rms."""
    judging = effect_twin(any_declaration(kind), SILENT)
    yard = EffectSize.of(specimen, judging, LINE_NOISE, rng, executor)
    if not case.blind:
        size = float(np.exp(rng.uniform(*np.log(SIZE))))
        return {case.effect: of_size(yard, case.effect, size, rng)}, yard.noise
    card = specimen.cards[case.effect]
    values = {p.name: float(p.sigma * rng.uniform(0.7, 1.5)) for p in card.amplitudes}
    return {case.effect: {**card.zero(), **values}}, yard.noise


def _recorded(
    specimen: Specimen, experiment: AcquiredExperiment, hidden: Mapping[str, Values], noise: float, folder: Path
) -> Path:
    """Record a campaign on the simulated rig."""
    folder.parent.mkdir(parents=True, exist_ok=True)
    truth = folder.with_suffix(".truth.json")
    write_json(truth, {"effects": hidden})
    session = Session(specimen.rig(0, hidden, noise, truth), experiment.limits)
    acquired = experiment.model_dump(mode="json", exclude={"simulation"})
    acquire_campaign(session, experiment, folder, Source(truth.name, sha256(truth)), acquired, unobserved)
    return folder


def _compared(folder: Path, held: Mapping[str, Values], executor: Executor) -> Compared:
    """Fit the twin without any of the effects to a campaign."""
    return compared_plainly(load_campaign(folder), 50.0, SILENT, executor, held)


def _questions(
    compared: Compared, case: HiddenCase, seen: Sequence[Told], executor: Executor
) -> tuple[Compared, tuple[Question, ...]]:
    """Return what is open, as a comparison would put it, with the likeliest effect on."""
    if case.blind:
        return compared, tuple(Question(name) for name in case.effects)
    best = max((one for one in seen if one.effect != NOTHING), key=lambda one: one.log_evidence)
    values = dict(zip((card.name for card in best.cards), best.values.tolist(), strict=True))
    on = {best.effect: {**compared.model.cards[best.effect].zero(), **values}}
    state = compared.fit.state.with_effects(on)
    fit = fit_gap(compared.model, compared.sweeps, state, (best.effect,), executor)
    found = dict(fit.state.effects[best.effect])
    asked = tuple(Question(best.effect, name, found) for name in case.effects if name != best.effect)
    return replace(compared, fit=fit), asked


def _measured(
    planned: Plan,
    chosen: Measurement,
    experiment: AcquiredExperiment,
    hidden: Mapping[str, Values],
    noise: float,
    seen: Sequence[Told],
    case: HiddenCase,
    folder: Path,
    rng: np.random.Generator,
    executor: Executor,
) -> Any:
    """Make the planned measurement, and decide with it."""
    del planned
    if chosen.experiment is None:
        readings = [
            (effect, parameter, _true(hidden, effect, parameter) + sigma * float(rng.standard_normal()), sigma)
            for (effect, parameter), sigma in chosen.readings.items()
            if effect in case.effects
        ]
        return decided(seen, readings=readings)
    target = folder / NAME
    write_next_experiment(target, _table(experiment), chosen)
    following = read_acquired_experiment(target)
    now, held = dict(hidden), {}
    if chosen.mass and chosen.place is not None:
        held = known_mass(chosen.place, chosen.mass)
        now |= held
    for name in set(chosen.turned) & set(now):
        now[name] = {parameter: -value for parameter, value in now[name].items()}
    second = _recorded(Specimen.of([following]), following, now, noise, folder / "second")
    compared = _compared(second, held, executor)
    told_then = told(compared.model, compared.sweeps, compared.fit.state, case.effects, executor)
    return decided(told_then) if case.blind else decided(seen, told_then, chosen.turned)


def _true(hidden: Mapping[str, Values], effect: str, parameter: str) -> float:
    return float(hidden.get(effect, {}).get(parameter, 0.0))


def _table(experiment: AcquiredExperiment) -> dict[str, Any]:
    """Return an experiment's file as a table, what its dump leaves out included."""
    table = experiment.model_dump(mode="json", exclude_none=True)
    if experiment.simulation is not None:
        table["simulation"]["laws"] = experiment.simulation.laws.model_dump(mode="json")
        table["simulation"]["gain"] = experiment.simulation.gain
    return table


if __name__ == "__main__":
    main()
