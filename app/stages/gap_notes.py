"""Notes of the gap stage: effects that were not tried, and the error of the twin."""

from collections.abc import Mapping

ROUGH_TWIN_ERROR = 2e-3
"""Certified error of the twin with effects above which a note says so; usual twins stay below."""


def missing_words(not_tried: Mapping[str, str]) -> tuple[str, ...]:
    """Return a note for each effect that could not be tried, with what to declare for it."""
    return tuple(f"{name} was not tried: for it, declare {wanted}" for name, wanted in not_tried.items())


def roughness(error: float) -> tuple[str, ...]:
    """Return a note where the certified `error` of the twin, a share of its peak, is larger than usual."""
    if error <= ROUGH_TWIN_ERROR:
        return ()
    return (
        f"the twin with several effects at half of their ranges has an error of {100 * error:.2g} % of its peak "
        f"(usual: below {100 * ROUGH_TWIN_ERROR:.2g} %): large parameters are no more certain than that. Check "
        "whether patches nearly touch an edge or each other",
    )
