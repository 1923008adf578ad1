"""A run in words, for a reader who decides and does not fit: the plate, what its twin lacked, what to do next."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from analysis.estimates import doubts, untold
from analysis.material import Material, MaterialLaws, MaterialSigma
from analysis.updated import GOOD_MISFIT
from app.files.results.best_twin import BY_UPDATE, BestTwin, TwinOfRun
from app.summaries.focusing import LEAST_CONTRAST
from app.summaries.gap import answer_words, description_words, found_words, plan_words, title, titles_of, told
from app.summaries.modes import no_fit_words
from app.summaries.numbers import FIXED, roughly, span

Record = Mapping[str, Any]
USUAL_TEMPERATURE = 20.0
"""Temperature at which the plate is described if the laws reach it, degrees Celsius."""
MOST_ESTIMATES = 3
"""Estimates that are named where there are no laws: of repeats at one temperature there may be many."""
REGIONS_NAMED = 3
"""Places of what is left that are named."""
NOTHING_LEFT = "Nothing beyond the noise."
LONG = "docs/guide/closing-a-gap.md"


@dataclass(frozen=True)
class Worth:
    """What the corrected twin is worth for filters.

    Attributes
    ----------
    contrast : float
        Largest gain of mean contrast over filters from the laws of flexura update.
    temperature : float
        Where, degrees Celsius.
    """

    contrast: float
    temperature: float


@dataclass(frozen=True)
class Briefing:
    """A page of words.

    Attributes
    ----------
    headline : str
    settled : bool
        Whether nothing is left open.
    first : tuple of str
        What has to be known before all else.
    parts : tuple of (str, tuple of str)
        Headings and their sentences.
    """

    headline: str
    settled: bool
    first: tuple[str, ...]
    parts: tuple[tuple[str, tuple[str, ...]], ...]

    def lines(self) -> list[str]:
        """Return it as text, one sentence to a line."""
        found = [self.headline, *self.first]
        for heading, sentences in self.parts:
            found += [f"{heading}:", *(f"  {sentence}" for sentence in sentences)]
        return found


def briefing(best: BestTwin, record: Record | None, campaign: str, worth: Worth | None = None) -> Briefing:
    """Say in words what a run found.

    Parameters
    ----------
    record : mapping or None
        Of its comparison, see `app.files.results.gap_json`; None without one.
    campaign : str
        How commands name the campaign, `app.files.bad_file.quoted` already.
    worth : Worth, optional
        Of the correction, for filters.
    """
    if record is None:
        return _without_comparison(best, campaign)
    if no_fit_words(record.get("pairing")):
        return _no_fit(record, campaign)
    verdict = record["verdict"]
    makers = {"explained": _named, "partly_explained": _named, "unknown": _unknown}
    found = _nothing(best, record, campaign) if verdict == "none" else makers[verdict](best, record, worth)
    answered = tuple(answer_words(record))
    return replace(found, parts=(("Answer", answered), *found.parts)) if answered else found


def _without_comparison(best: BestTwin, campaign: str) -> Briefing:
    updated = best.twin.updated
    ratio = float((updated.misfit / updated.noise_floor).max())
    lacks = ratio > GOOD_MISFIT
    headline = f"The twin misses at most {ratio:.2f} times the noise of the measurement"
    headline += ": it lacks something that the plate has." if lacks else "."
    parts = [("The plate", _material(best.twin, open_=lacks)), *_known(best.twin, ())]
    parts.append(("Next", (f"Ask what the twin lacks: flexura gap {campaign}",)))
    return _brief(headline, not lacks, best.notes, parts)


def _no_fit(record: Record, campaign: str) -> Briefing:
    said = tuple(no_fit_words(record.get("pairing")))
    parts = [("Next", (f"Correct the declaration and compare again: flexura gap {campaign}", f"More: {LONG}"))]
    return _brief("This is no fit: the numbers below mean nothing.", False, said, parts)


def _nothing(best: BestTwin, record: Record, campaign: str) -> Briefing:
    before = record["gap"]["baseline"]["relative_misfit"]
    on = f" It has {best.names}." if best.effects else ""
    headline = f"Nothing is missing: the twin agrees with the plate to the noise of the measurement.{on}"
    sentence = f"The twin misses {100 * before:.2g} % of the response, which is noise."
    parts = [("The plate", _material(best.twin)), ("Twin and plate", (sentence,))]
    unseen, steps = _unseen(record), ["Use E, ν and η as they are: nothing has to be corrected."]
    if unseen and not record.get("plan"):
        steps.append(f"Where the rest matters, ask what would show it: flexura gap {campaign} --plan")
    known = _known(best.twin, unseen)
    return _brief(headline, True, best.ignored, [*parts, *known, ("Next", (*plan_words(record), *steps))])


def _named(best: BestTwin, record: Record, worth: Worth | None) -> Briefing:
    whole, left = record["verdict"] == "explained", record["unexplained"]["share"] or 0.0
    titles = titles_of(record)
    found = "; ".join(found_words(effect, titles) for effect in record["effects"])
    headline = f"What the twin lacked: {found}. "
    if whole:
        headline += "With it, twin and plate agree to the noise of the measurement."
    else:
        headline += f"This explains {_but(left)} of the gap; the rest is still missing."
    parts = [
        ("The plate", _material(best.twin, open_=not whole and record.get("scatter") is None)),
        ("How sure", tuple(_how_sure(effect, record) for effect in record["effects"])),
        ("What it is worth", tuple(_worth(best, record, worth))),
        ("What is left", (*_left(record), *description_words(record)) if not whole else (NOTHING_LEFT,)),
        *_known(best.twin, _unseen(record)),
        ("Next", (*plan_words(record), *(_next(effect, titles_of(record)) for effect in record["effects"]))),
    ]
    return _brief(headline, whole, best.ignored, parts)


def _unknown(best: BestTwin, record: Record, worth: Worth | None) -> Briefing:
    del worth  # nothing was named
    before = record["gap"]["baseline"]
    largest = max((region["largest_sigma"] for region in record["where"]["regions"]), default=0.0)
    seen = f"The twin misses {100 * before['relative_misfit']:.2g} % of the response"
    seen += f", in places {largest:.0f} times the noise." if largest > 0.0 else "."
    steps = [
        "Is a quantity doubtful? Measure it again.",
        "Is the rest of the declaration right: mass, size, places, order of the channels?",
        "Is a cable loose, or a sweep disturbed, where the gap is?",
        f"More: {LONG}",
    ]
    parts = [
        (
            "What is seen",
            (seen, *_scatter(record), *_places(record["where"]["regions"]), *description_words(record)),
        ),
        ("The plate", _material(best.twin, open_=record.get("scatter") is None)),
        *_known(best.twin, _unseen(record)),
        ("Next", (*plan_words(record), *steps)),
    ]
    headline = "Something is missing in the twin, and no effect of the library explains it."
    return _brief(headline, False, best.ignored, parts)


def _brief(
    headline: str, settled: bool, first: Sequence[str], parts: Sequence[tuple[str, Sequence[str]]]
) -> Briefing:
    return Briefing(headline, settled, tuple(first), tuple((name, tuple(said)) for name, said in parts if said))


def _material(twin: TwinOfRun, *, open_: bool = False) -> tuple[str, ...]:
    """E, nu and eta with their standard deviations, of laws in the middle and at both ends of the temperatures."""
    laws, found = twin.laws, twin.updated
    said = []
    if laws is not None:
        low, high = laws.temperature_range
        middle = USUAL_TEMPERATURE if low < USUAL_TEMPERATURE < high else 0.5 * (low + high)
        said = [_constants(at, laws.at(at), laws.sigma(at)) for at in (middle, low, high)]
    else:
        if found.sheet is None:
            rows = np.flatnonzero(found.settled)[:MOST_ESTIMATES]
            said = [_constants(found.temperature[n], found.material, found.sigma, n) for n in rows.tolist()]
        said.append("Laws of E, ν and η over temperature need estimates at 3 temperatures or more.")
    said.append("E is Young's modulus (stiffness), ν Poisson's ratio, η the loss factor (damping).")
    if open_:
        said.append("Part of what is missing is in these values: their true errors are larger.")
    return tuple(said)


def _constants(temperature: float, value: Material, sigma: MaterialSigma, n: int = 0) -> str:
    """E, nu and eta of row `n` in a sentence."""
    modulus = roughly(value.youngs_modulus[n] / 1e9, sigma.youngs_modulus[n] / 1e9, "GPa")
    ratio = roughly(value.poisson_ratio[n], sigma.poisson_ratio[n])
    loss = roughly(100 * value.loss_factor[n], 100 * sigma.loss_factor[n], "%")
    return f"At {temperature:z.0f}{FIXED}°C: E{FIXED}{modulus}, ν{FIXED}{ratio}, η{FIXED}{loss}."


def _how_sure(effect: Record, record: Record) -> str:
    """Say how probable an effect is, and what it cannot be told from."""
    titles = titles_of(record)
    name = title(effect["name"], titles)
    said = f"{_first(name)}: {100 * effect['probability']:.0f}{FIXED}%"
    if not effect["equivalent"]:
        return f"{said}; the rest is for other effects of the library, and for none."
    others = " or ".join(title(other, titles) for other in effect["equivalent"])
    return f"{said}; but this campaign cannot tell it from: {others}."


def _next(effect: Record, titles: Mapping[str, str]) -> str:
    how = told(effect["separated_by"], titles)
    return f"To tell them apart: {how}." if effect["equivalent"] else f"To confirm it: {how}."


def _worth(best: BestTwin, record: Record, worth: Worth | None) -> list[str]:
    """Say what the correction changes in the laws, closes of the gap, and gains for filters."""
    said = []
    if best.twin.laws is not None and best.before is not None:
        said.append(_change(best.twin.laws, best.before, best.before_said))
    left = record["unexplained"]["share"]
    if left is not None:
        explained = _share(1.0 - left) if record["verdict"] == "explained" else _but(left)
        said.append(f"{_first(explained)} of the gap is explained{_held_out(record)}.")
    if worth is not None:
        gain = "nothing"
        if worth.contrast >= LEAST_CONTRAST:
            gain = f"up to {worth.contrast:.3f} of contrast (at {worth.temperature:.0f}{FIXED}°C)"
        said.append(f"Filters gain {gain} over those from the laws {BY_UPDATE}.")
    return said


def _held_out(record: Record) -> str:
    closure = record["gap"]["held_out"]["closure"]
    return "" if closure is None else f"; of data that were not fitted, {_share(closure)}"


def _share(value: float) -> str:
    """Return a share in per cent; close to all, with the digits that tell it from all."""
    percent = 100.0 * value
    if percent >= 99.995:
        return "all"
    return f"{percent:.{0 if percent < 99.0 else 2}f}{FIXED}%"


NEARLY_ALL = 0.005
"""Share of a gap that is left below which what is explained is told by it: 100 % would seem to be all."""


def _but(left: float) -> str:
    """Return the share that is explained where some is left."""
    if left >= NEARLY_ALL:
        return f"{100.0 * (1.0 - left):.0f}{FIXED}%"
    return f"all but {100.0 * left:.1g}{FIXED}%"


def _change(laws: MaterialLaws, earlier: MaterialLaws, said: str) -> str:
    """Say by how much E, nu and eta change, and where most; `said` is what the earlier laws are."""
    low = max(laws.temperature_range[0], earlier.temperature_range[0])
    high = min(laws.temperature_range[1], earlier.temperature_range[1])
    t = np.linspace(low, high, 61)
    now, before = laws.at(t), earlier.at(t)
    modulus = 100.0 * (now.youngs_modulus / before.youngs_modulus - 1.0)
    loss = 100.0 * (now.loss_factor / before.loss_factor - 1.0)
    ratio = now.poisson_ratio - before.poisson_ratio
    at = int(np.abs(modulus).argmax())
    return (
        f"E changes by {span(modulus, '+z.1f')}{FIXED}% of itself (most at {t[at]:.0f}{FIXED}°C: "
        f"{before.youngs_modulus[at] / 1e9:.3g} GPa {said}), ν by {span(ratio, '+z.3f')}, "
        f"η by {span(loss, '+z.1f')}{FIXED}% of itself."
    )


def _left(record: Record) -> tuple[str, ...]:
    share = record["unexplained"]["share"] or 0.0
    return (
        f"{100.0 * share:.2g}{FIXED}% of the gap.",
        *_scatter(record),
        *_places(record["unexplained"]["where"]),
    )


def _scatter(record: Record) -> list[str]:
    """Say how far resonances of the plate are from those of the twin, where that is a part of the result."""
    scatter = record.get("scatter")
    if scatter is None:
        return []
    frequency, height = (100 * scatter["final"][what] for what in ("frequency", "amplitude"))
    return [
        f"Resonances of the plate differ from the twin's by {frequency:.2g}{FIXED}% in frequency and "
        f"{height:.2g}{FIXED}% in height (standard deviations); the ± above contain this."
    ]


def _places(regions: Sequence[Record]) -> list[str]:
    """Say where a residual is."""
    said = []
    for region in regions[:REGIONS_NAMED]:
        frequency = _range(region["frequency_hz"], "Hz")
        temperature = _range(region["temperature_c"], "°C")
        said.append(f"{100 * region['share']:.0f} % of it at {region['channel']}, {frequency}, {temperature}.")
    return said


def _range(ends: Sequence[float], unit: str) -> str:
    low, high = (f"{end:z.0f}" for end in ends)
    return f"{low}{FIXED}{unit}" if low == high else f"{low} to {high}{FIXED}{unit}"


def _known(twin: TwinOfRun, unseen: Sequence[str]) -> list[tuple[str, Sequence[str]]]:
    """Say how well the declaration is known, and what the campaign could not show."""
    declared = twin.declared
    said = [f"{_first(one)}." for one in doubts(declared)]
    if declared and not said:
        said = ["Nothing that was declared is found beyond its tolerance; the ± of E, ν and η contain these."]
        if asked := untold(declared):
            said.append(
                f"Not told by the data, and taken as declared: {', '.join(asked)} of the plate. Where one of them "
                "is off by more than its tolerance, E is off by more than its ±."
            )
    if lag := next((one.tolerance for one in declared if one.name == "plate_lag"), None):
        of_laws = float(np.ptp(twin.updated.temperature)) > 0.0
        contained = "the ± contain" if of_laws else "of one temperature the ± do not contain"
        said.append(
            f"The temperatures are the air's, on one ramp: {contained} that the plate may lag {lag:.0f}{FIXED}s "
            "behind. Measure up and down, or on the plate."
        )
    return [("How well known", [*said, *unseen])]


def _unseen(record: Record) -> list[str]:
    titles = titles_of(record)
    return [
        f"Cannot be seen with this campaign: {title(one['name'], titles)}; it needs {told(one['needs'], titles)}."
        for one in record["observability"]
        if not one["observable"]
    ]


def _first(text: str) -> str:
    """Return a sentence with a capital first letter."""
    return text[:1].upper() + text[1:]
