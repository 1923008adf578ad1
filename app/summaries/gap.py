"""gap.json in words: tables and sentences.

Effects have their names, and what was found is told in units that people use. Other parts are the plan of the next
experiment, and the description of an unknown cause.
"""

import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from analysis.effect_card import PEOPLES
from app.files.results.best_twin import BY_UPDATE
from app.summaries.modes import no_fit_words, pairing_tables
from app.summaries.numbers import FIXED, roughly, with_sigma
from app.summaries.table import Table

Record = Mapping[str, Any]


def summary(record: Record, run: Path) -> str:
    """Return one line: verdict, what was found, and where it stands."""
    return f"{headline(record)}; {record['seconds']:.1f} s; results in {run}"


USUAL = {"kg": "g", "m": "mm"}
"""Units for people of parameters whose card names none."""


def title(name: str, titles: Mapping[str, str]) -> str:
    """Return the name of an effect for people."""
    return titles.get(name) or name.replace("_", " ")


CODE_NAME = re.compile(r"\b(?:an? )?([a-z]+(?:_[a-z]+)+)\b")
"""A name of the library within a sentence, with its article."""


def told(text: str, titles: Mapping[str, str]) -> str:
    """Return a sentence of an effect's card with other effects called by their names for people, in quotes."""
    return CODE_NAME.sub(lambda m: f"“{titles[m[1]]}”" if m[1] in titles else m[0], text)


def titles_of(record: Record) -> dict[str, str]:
    """Return the names for people of all effects in the record of a comparison."""
    found = dict(record.get("titles", {}))
    for effect in record["effects"]:
        if effect.get("title"):
            found[effect["name"]] = effect["title"]
    return found


def in_words(effect: Record) -> str:
    """Return what was found of an effect, with values: "an added mass of 0.800 ± 0.002 g at the cable"."""
    shown = effect.get("shown_units", {})
    values = {name: _value(one, shown.get(name, "")) for name, one in effect["parameters"].items()}
    phrase = str(effect.get("phrase", ""))
    if phrase:
        for name, value in values.items():  # not str.format: the file may be anybody's
            phrase = phrase.replace(f"{{{name}}}", value)
        return phrase.replace("{{", "{").replace("}}", "}")
    listed = ", ".join(f"{name.replace('_', ' ')} {value}" for name, value in values.items())
    return f"{effect.get('title') or effect['name'].replace('_', ' ')}: {listed}"


def found_words(effect: Record, titles: Mapping[str, str]) -> str:
    """Return `in_words`, and the effects that could not be told from it."""
    others = " or ".join(title(name, titles) for name in effect["equivalent"])
    return in_words(effect) + (f" (or, not to be told from it: {others})" if others else "")


def _value(one: Record, shown: str) -> str:
    """Return a value with its standard deviation in the unit for people."""
    shown = shown or USUAL.get(one["unit"], "")
    factor = PEOPLES.get((one["unit"], shown), 1.0)
    unit = shown if (one["unit"], shown) in PEOPLES else one["unit"]
    return roughly(factor * one["value"], factor * one["sigma"], unit)


def headline(record: Record) -> str:
    """Return verdict, effects found, and chi2 before and after, in one line."""
    titles = titles_of(record)
    found = ", ".join(named(effect, titles) for effect in record["effects"])
    words = concluded(record)
    if record["effects"]:
        words += f": {found}" if record["verdict"] != "unknown" else f" (hints: {found})"
    return f"{words}; chi2 per dof {' -> '.join(chi2_before_and_after(record))}"


def modes_before(record: Record) -> str:
    """Say of which twin the modes before are: its misfit is another than that of the comparison's own twin.

    Nothing where no gap was found: there is no other.
    """
    if record["verdict"] == "none":
        return ""
    return "with the effects of the twin file" if record["starting_effects"] else BY_UPDATE


def claims(record: Record) -> bool:
    """Whether effects are in the twin that is issued; else those in the record are hints."""
    return record["verdict"] in ("explained", "partly_explained")


def chi2_before_and_after(record: Record) -> list[str]:
    """Chi2 per degree of freedom without effects and, where some are claimed, with them."""
    parts = ("baseline", "final") if claims(record) else ("baseline",)
    return [f"{record['gap'][part]['chi2_per_dof']:.3g}" for part in parts]


def concluded(record: Record) -> str:
    """Return the verdict in words, or that there is no fit to judge."""
    return "unknown: this is no fit" if no_fit_words(record.get("pairing")) else verdict_words(record["verdict"])


def verdict_words(verdict: str) -> str:
    """Return a verdict in words."""
    return {
        "none": "no gap: twin and data agree to the noise",
        "explained": "gap explained",
        "partly_explained": "gap partly explained",
        "unknown": "unknown: a gap that no effect of the library explains",
    }[verdict]


def named(effect: Record, titles: Mapping[str, str] | None = None) -> str:
    """Name of an effect, with those it cannot be distinguished from; for people where `titles` are given."""
    names = [effect["name"], *effect["equivalent"]]
    return " or ".join(names if titles is None else [title(name, titles) for name in names])


def estimate(parameter: Record) -> str:
    """Value, standard deviation to two digits, and unit; the value to the same decimal."""
    return with_sigma(parameter["value"], parameter["sigma"], parameter["unit"])


def gap_closed(part: Record) -> str:
    """Return the share of a gap that closes on held-out data, with its standard deviation; empty without a gap."""
    if part["closure"] is None:
        return ""
    return with_sigma(100.0 * part["closure"], 100.0 * (part.get("closure_sigma") or 0.0), "%")


NOTHING = "nothing"
"""Name in ``gap.json`` of the answer that it was none of the effects."""
MEASUREMENTS_SHOWN = 6
"""Measurements in the table, the best first."""


def question_words(question: Record, titles: Mapping[str, str]) -> str:
    """Say what is open: ``draught or thickness taper``, or ``thermal lag: there or not``."""
    name = title(question["effect"], titles)
    return (
        f"{name}: there or not" if question["rival"] is None else f"{name} or {title(question['rival'], titles)}"
    )


def plan_rows(record: Record) -> list[tuple[str, str, str, str]]:
    """Return rows of measurement, hours, questions settled, and separation gained per hour, the best first."""
    plan, titles = record["plan"], titles_of(record)
    rows = []
    for one in plan["measurements"][:MEASUREMENTS_SHOWN]:
        settled = "; ".join(question_words(plan["questions"][k], titles) for k in one["settles"])
        settled = settled or f"none (+{one['gain_sigma']:.1f} sigma)"
        rows.append((one["words"], f"{one['hours']:.1f}", settled, f"{one['gain_per_hour']:.1f}"))
    return rows


HEADINGS = ("measurement", "hours", "would settle", "sigma per hour")


def plan_table(record: Record) -> Table:
    """Return the table of measurements; without rows where there is no plan."""
    rows = tuple(map(tuple, plan_rows(record) if record.get("plan") else ()))
    return Table("What to measure next", HEADINGS, rows, words=frozenset(range(len(HEADINGS))))


def plan_words(record: Record) -> list[str]:
    """Say what is to be measured next, and why; an empty list where there is no plan."""
    plan = record.get("plan")
    if not plan:
        return []
    if not plan["questions"]:
        return ["Nothing is open that another measurement could settle."]
    chosen = plan["next"]
    if chosen is None:
        return ["None of the measurements that were simulated would settle what is open."]
    titles = titles_of(record)
    best = plan["measurements"][0]
    said = [f"{chosen['words']} ({chosen['hours']:.1f} h)"]
    for k in best["settles"]:
        question = plan["questions"][k]
        before, after = question["separation_sigma"], best["separation_sigma"][k]
        said.append(
            f"It would settle {question_words(question, titles)}: {after:.0f} sigma apart, {before:.1f} now."
        )
    if not best["settles"]:
        said.append(f"It settles nothing alone, and adds {best['gain_sigma']:.1f} sigma.")
    if chosen["experiment"]:
        said.append(f"Its experiment: {chosen['experiment']}.")
    if chosen["to_complete"]:
        said.append(chosen["to_complete"])
    return said


def answer_words(record: Record) -> list[str]:
    """Say what both campaigns settle of an earlier plan's questions; an empty list where none was named."""
    found = record.get("answer")
    if not found:
        return []
    titles = titles_of(record)
    others = sorted(found["relative_nats"].items(), key=lambda pair: -pair[1])
    best, second = others[0], others[1] if len(others) > 1 else None
    name = _or_nothing(best[0], titles)
    if second is None:
        return [f"Both campaigns together: {name}."]
    behind = f"{_or_nothing(second[0], titles)} is {-second[1]:.0f} nats behind"
    if found["settled"] is None:
        return [f"Both campaigns together do not settle it: {name}, and {behind}."]
    return [f"Both campaigns together settle it: {name}; {behind}."]


def _or_nothing(name: str, titles: Mapping[str, str]) -> str:
    return "none of them" if name == NOTHING else title(name, titles)


def tables(record: Record) -> list[Table]:
    """Return tables of paired modes, effects, agreement, what is left and what could not be seen."""
    pairing = record.get("pairing")
    no_fit = bool(no_fit_words(pairing))
    every = (
        *pairing_tables(pairing, modes_before(record)),
        *(() if no_fit else (_found(record),)),
        _agreement(record),
        *(() if no_fit else (_where(record), _unseen(record), plan_table(record))),
    )
    return [table for table in every if table.rows]


def _table(title: str, headings: Sequence[str], rows: Iterable[Sequence[str]]) -> Table:
    return Table(title, tuple(headings), tuple(map(tuple, rows)), words=frozenset(range(len(headings))))


def _found(record: Record) -> Table:
    title = "Hints, nothing claimed" if record["verdict"] == "unknown" else "What the twin lacked"
    headings = ["effect", "parameters", "probability", "evidence [nats]"]
    alike = any(effect["equivalent"] for effect in record["effects"])
    rows = []
    for effect in record["effects"]:
        values = "\n".join(f"{name} {estimate(p)}" for name, p in effect["parameters"].items())
        cells = [named(effect), values, f"{effect['probability']:.3f}", f"{effect['log_evidence_gain']:.0f}"]
        rows.append([*cells, *([effect["separated_by"] if effect["equivalent"] else ""] if alike else [])])
    return _table(title, [*headings, *(["distinguished by"] if alike else [])], rows)


def held_out_parts(record: Record) -> list[Record]:
    """Return what effects were tried on besides the data they were fitted to; nothing where none was fitted."""
    gap = record["gap"]
    return [gap["held_out"], *gap.get("held_out_also", ())] if record["effects"] else []


def _agreement(record: Record) -> Table:
    found, gap = bool(record["effects"]), record["gap"]
    parts = [("all", gap["baseline"], gap["final"] if claims(record) else None, "")]
    parts += [
        (f"held out: {part['what']}", part["baseline"], part["final"], gap_closed(part))
        for part in held_out_parts(record)
    ]
    rows = [
        (
            data,
            f"{before['chi2_per_dof']:.4g}",
            f"-> {after['chi2_per_dof']:.4g}" if after else "",
            f"{100 * before['relative_misfit']:.2f} %",
            f"-> {100 * after['relative_misfit']:.2f} %" if after else "",
            closed,
        )
        for data, before, after, closed in parts
    ]
    if not any(after for _, _, after, _ in parts):
        return _table(
            "Twin and data", ("data", "chi2 per dof", "misfit"), [(row[0], row[1], row[3]) for row in rows]
        )
    title = "Before and after" if found else "Twin and data"
    return _table(title, ("data", "chi2 per dof", "", "misfit", "", "gap closed"), rows)


def _where(record: Record) -> Table:
    open_ = record["verdict"] in ("partly_explained", "unknown")
    rows = [
        (
            region["channel"],
            "{:.0f} to {:.0f}".format(*region["frequency_hz"]),
            "{:.0f} to {:.0f}".format(*region["temperature_c"]),
            f"{100 * region['share']:.0f} %",
        )
        for region in (record["unexplained"]["where"][:5] if open_ else [])
    ]
    return _table("What is left", ("channel", "frequency [Hz]", "temperature [°C]", "share of it"), rows)


def _unseen(record: Record) -> Table:
    title = "Not observable with this campaign: neither claimed nor excluded"
    rows = [(entry["name"], entry["needs"]) for entry in record["observability"] if not entry["observable"]]
    return _table(title, ("effect", "what would show it"), rows)


LEAST_NATS = 6.0
"""Evidence below which no form describes the cause."""
WEAK_SHARE = 0.5
"""Share of the gap below which a description is called partial."""
ON = {"temperature": "temperatures", "ramp": "ramps", "level": "levels", "channel": "channels", "time": "times"}


def description_words(record: Record) -> list[str]:
    """Say what an unknown cause acts like, where, and on what it depends; an empty list without a description."""
    found = record.get("description")
    if not found:
        return []
    best = found["best"]
    if best["log_evidence_gain"] < LEAST_NATS:
        return [
            "It acts neither like a load at one place, nor like a modulus, a loss factor or a gain that changes "
            "with frequency."
        ]
    alike = [ON[one["on"]] for one in found["dependence"] if one["constant"]]
    said = f"What is missing acts like {_form(best)}"
    said += f", alike at all {_listed(alike)}." if alike else "."
    words = [said, *(_varies(one) for one in found["dependence"] if not one["constant"])]
    if best["or_at_m"]:
        places = " or ".join(_near(*place) for place in best["or_at_m"])
        words.append(f"On this plate it would look the same {places}.")
    share = f"{100 * best['share']:.0f}{FIXED}%"
    words.append(
        f"It explains {share} of {'what is left' if record.get('effects') else 'the gap'}"
        + ("." if best["share"] >= WEAK_SHARE else ": a hint, no more.")
    )
    if found["effect_file"]:
        folder = found["effect_file"].split("/")[0]
        words.append(
            f"As an effect of your own: {found['effect_file']} (compare again with --effects RUN/{folder})."
        )
    return words


def _form(best: Record) -> str:
    name, known = best["name"], best["parameters"]
    if name == "modulus":
        return "a material that changes with frequency: " + _over(best["curve"], "modulus", "loss factor")
    if name == "gain":
        return "a gain that changes with frequency: " + _over(best["curve"], "size", "phase", angle=True)
    what = {
        "mass": lambda: f"an added mass of {_said(known['mass'], 1e3, 'g')}",
        "spring": lambda: f"a spring of {_said(known['stiffness'], 1.0, 'N/m')}",
        "dashpot": lambda: f"a dashpot of {_said(known['damping'], 1.0, 'N s/m')}",
        "resonator": lambda: (
            f"a mass of {_said(known['mass'], 1e3, 'g')} on a spring (resonance "
            f"{_said(known['resonance'], 1.0, 'Hz')}, loss factor {_said(known['loss'], 100.0, '%')})"
        ),
        "load": lambda: f"a load of no simple form ({_apparent(best['curve'])})",
    }[name]()
    place = f"x{FIXED}{_said(known['x'], 1e3, 'mm')}, y{FIXED}{_said(known['y'], 1e3, 'mm')}"
    return f"{what} near {place}"


def _said(one: Record, factor: float, unit: str) -> str:
    return roughly(factor * one["value"], factor * one["sigma"], unit)


def _near(x: float, y: float) -> str:
    return f"near x{FIXED}{1e3 * x:.0f}, y{FIXED}{1e3 * y:.0f}{FIXED}mm"


def _over(curve: Record, first: str, second: str, *, angle: bool = False) -> str:
    """Say two relative curves at both ends of the band; what stays within two sigma of its mean is left out."""
    low, high = curve["frequency_hz"][0], curve["frequency_hz"][-1]
    said = []
    for name, key in ((first, "first"), (second, "second")):
        values, sigmas = curve[key], curve[f"sigma_{key}"]
        if max(values) - min(values) < 2.0 * max(sigmas):
            said.append(f"{name} alike")
            continue
        factor, unit = (57.3, "°") if angle and key == "second" else (100.0, "%")
        ends = [f"{factor * values[k]:+.2g}{FIXED}{unit}" for k in (0, -1)]
        said.append(f"{name} {ends[0]} at {low:.0f}{FIXED}Hz, {ends[1]} at {high:.0f}{FIXED}Hz")
    return "; ".join(said)


def _apparent(curve: Record) -> str:
    """Say the apparent mass at both ends of the band and where it is largest."""
    sizes = [abs(value) for value in curve["first"]]
    chosen = sorted({0, sizes.index(max(sizes)), len(sizes) - 1})
    return "apparent mass " + ", ".join(
        f"{1e3 * curve['first'][k]:+.2g}{FIXED}g at {curve['frequency_hz'][k]:.0f}{FIXED}Hz" for k in chosen
    )


def _varies(one: Record) -> str:
    pairs = list(zip(one["label"], one["factor"], one["sigma"], strict=True))
    shown: Sequence[tuple[str, float, float]] = (
        pairs if len(pairs) <= 4 else [pairs[0], pairs[len(pairs) // 2], pairs[-1]]
    )
    told = ", ".join(f"{roughly(factor, sigma)} at {label}" for label, factor, sigma in shown)
    return f"Its strength changes with the {one['on']}: {told} (1: in the mean)."


def _listed(words: Sequence[str]) -> str:
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"
