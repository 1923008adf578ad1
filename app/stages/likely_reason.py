"""Likely reason why a twin is no fit: other declarations, tried on coarse models against one sweep's modes."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from analysis.experiment import Experiment
from analysis.geometry.fault import GeometryError
from analysis.material import MaterialBox
from analysis.pairing.coarse_trial import CoarseTrial, SweepModes, tried
from analysis.pairing.paired_sweeps import LEAST_SHARE
from analysis.plate_material import material_box
from analysis.progress import Progress
from analysis.updating.modulus_scan import ModulusScan, scanned_box
from app.stages.alternatives import Alternative, exchanged_channels, orthotropic, other_lengths, other_places
from app.stages.declaration_check import sentence
from simulation.reduction.coarse_plate import CoarsePlate

STAGE = "looking for the reason"
LIKELY_PAIRED_SHARE = 0.8
"""Share of paired modes from which an alternative is named: right ones had 0.95 and more, a wrong length beside a
wrong place, the length alone put right, 0.73."""
CLEAR_PAIRED_SHARE = 0.85
"""Share of paired modes from which no further alternatives are tried."""
LEAST_SHARE_GAIN = 0.2
"""Least gain in the share over the declaration's own; where this was tried, right ones gained 0.4 to 0.6."""
EQUAL_SHARES = 0.1
"""Difference of shares up to which two alternatives are both named: mirrored plates answer alike."""


@dataclass(frozen=True)
class LikelyReason:
    """What makes the modes pair, in a sentence, or that nothing tried does.

    Attributes
    ----------
    sentence : str
    wrong_declaration : bool
        Whether it is another declaration; an amount of an effect of the library is none.
    """

    sentence: str
    wrong_declaration: bool = False


Found = tuple[float, str, str]
"""Share of paired modes, sentence, and effect of the library or an empty string."""


def likely_reason(experiment: Experiment, sweep: SweepModes, report: Progress) -> LikelyReason:
    """Try alternatives to a declaration.

    Parameters
    ----------
    experiment : Experiment
        As declared.
    sweep : SweepModes
        One that the twin does not fit.
    report : callable
        Called with a stage's name and the share of it done.
    """
    report(STAGE, 0.0)
    box = material_box(experiment.plate.material)
    declared = _tried(experiment, box, sweep)
    if declared is None:
        return LikelyReason("no likely reason was looked for: the declared plate has no coarse model")
    found: list[Found] = []
    families = _families(experiment, box, sweep, declared)
    for done, family in enumerate(families):
        report(STAGE, (done + 1) / (len(families) + 1))
        found += family()
        if max(found, default=(0.0,))[0] >= CLEAR_PAIRED_SHARE:
            break
    report(STAGE, 1.0)
    return _concluded(declared, sorted(found, reverse=True))


def _concluded(declared: CoarseTrial, found: list[Found]) -> LikelyReason:
    """Choose the best of what was found, best first."""
    own, least = declared.pairs.counted, max(LIKELY_PAIRED_SHARE, declared.share + LEAST_SHARE_GAIN)
    if found and found[0][0] >= least:
        as_good = [words for share, words, _ in found[:2] if share >= max(least, found[0][0] - EQUAL_SHARES)]
        sentence = f"likely reason, tried on a coarse model that as declared has {own}: {', or: '.join(as_good)}"
        return LikelyReason(sentence, not found[0][2])
    if declared.share >= LEAST_SHARE:
        return LikelyReason(
            f"with a modulus of {declared.youngs_modulus / 1e9:.3g} GPa a coarse model of the declared plate has "
            f"{own}: the fit ended at a wrong material, or the sweeps do not belong together. Narrow the ranges "
            "in [plate.material], and look at the single sweeps"
        )
    return LikelyReason(
        f"no likely reason found: as declared, a coarse model has {own}; another thickness, mass or material, "
        "stiffness that differs along x and y, channels exchanged or inverted, another place of each transducer "
        "and other lengths, each alone, do not bring enough. Several of these may be wrong, or something that was "
        "not tried: outline, supports, holes. Or the plate has a large effect: flexura gap tries those of its "
        "library"
    )


def _families(
    experiment: Experiment, box: MaterialBox, sweep: SweepModes, declared: CoarseTrial
) -> list[Callable[[], Iterable[Found]]]:
    """Return what yields, for each kind of alternative, shares and sentences."""

    def material() -> Iterator[Found]:
        found = _tried(experiment, scanned_box(box), sweep)
        low, high = box.youngs_modulus
        if found is not None and not low <= found.youngs_modulus <= high:
            scan = ModulusScan(found.youngs_modulus, 1.0, declared.youngs_modulus, 0.0)
            yield (
                found.share,
                f"{sentence(experiment, sweep.temperature, scan)}. It then has {found.pairs.counted}",
                "",
            )

    def of(alternatives: Iterator[Alternative]) -> Iterator[Found]:
        for other in alternatives:
            found = _tried(other.experiment, box, other.sweep)
            if found is not None:
                yield found.share, f"{other.words}. It then has {found.pairs.counted}", other.effect

    return [
        material,
        lambda: of(orthotropic(experiment, sweep)),
        lambda: of(exchanged_channels(experiment, box, sweep)),
        lambda: of(other_places(experiment, box, sweep)),
        lambda: of(other_lengths(experiment, box, sweep)),
    ]


def _tried(experiment: Experiment, box: MaterialBox, sweep: SweepModes) -> CoarseTrial | None:
    """Try one declaration; None where no coarse model can be made of it."""
    try:
        return tried(CoarsePlate.of(experiment, box), box, sweep)
    except (RuntimeError, GeometryError, np.linalg.LinAlgError):
        return None
