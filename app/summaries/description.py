"""The description of an unknown cause in sentences, in units that people use."""

from collections.abc import Mapping, Sequence
from typing import Any

from app.summaries.numbers import FIXED, roughly

Record = Mapping[str, Any]
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
        f"It explains {share} of the gap" + ("." if best["share"] >= WEAK_SHARE else ": a hint, no more.")
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
