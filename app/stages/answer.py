"""Answer stage: what an earlier comparison left open, decided by its campaign and the planned one together."""

from collections.abc import Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from pathlib import Path

from analysis.gap.data.preparation import prepare
from analysis.gap.fitting.fit import fit_gap
from analysis.gap.fitting.state import starting_state
from analysis.gap.plan.decision import Decision, decided, told
from analysis.held_effects import HeldEffects
from analysis.progress import Progress
from analysis.recordings.frf_campaign import AnyCampaign
from analysis.twin_model import NO_EFFECTS, Effects
from analysis.updating.drift import to_first_order
from app.files.results.gap_json import open_before
from app.stages.compared import Compared
from app.stages.update import updated_twin
from app.twins.campaign_model import WORKERS, campaign_model, judging


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
    with ThreadPoolExecutor(WORKERS) as executor, judging(earlier):
        report("earlier campaign", 0.0)
        before = compared_plainly(earlier, mains, report, executor)
        report("answer", 0.0)
        decision = answer([before, now], effects, turned, executor)
        report("answer", 1.0)
    return decision
