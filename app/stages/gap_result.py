"""What ``flexura gap`` leaves in the run folder."""

import hashlib
import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import analysis
from analysis.campaign import Campaign
from analysis.plate_material import material_box
from analysis.updating.corrected_twin import CorrectedTwin, material_of
from app.files.atomic import write_json
from app.files.effect_cache import operators_key
from app.files.frf_file import save_frf
from app.files.gap_file import GapFigures, save_gap
from app.files.gap_json import gap_record
from app.files.laws_file import TwinFrf, save_laws
from app.files.provenance import provenance, sha256
from app.files.twin_file import Basis, Estimated, TwinEffect, TwinFile, TwinLaws, TwinOrigin, write_twin
from app.stages.gap import GapComparison

GAP, FIGURES, TWIN, LAWS = "gap.json", "gap.h5", "twin.toml", "laws-corrected.h5"


def made_from(campaign: Campaign, mains: float, start: Path | None, folder: Path | None) -> dict[str, Any]:
    """Provenance of a comparison: the campaign, the twin it began with, a user's effects."""
    inputs = dict(campaign.hashes)
    if start is not None:
        inputs[f"twin {start.name}"] = sha256(start)
    if folder is not None:
        inputs |= {f"effect {file.name}": sha256(file) for file in sorted(folder.glob("[!_]*.py"))}
    return provenance(inputs, {"mains": mains, "campaign": campaign.name})


def save_comparison(
    run: Path,
    campaign: Campaign,
    found: GapComparison,
    origin: dict[str, Any],
    based_on: str | None,
    seconds: float,
) -> dict[str, Any]:
    """Write gap.json, gap.h5, twin.toml and laws, and return what gap.json holds.

    ``laws.h5``, which `flexura update` writes, is written as it would if it is not there, else left alone. Laws
    under effects go to a file of their own, which is removed where no effect is on, lest an earlier run's be taken
    for this one's.
    """
    record = gap_record(found.report, found.given, origin, seconds)
    save_frf(run / "frf.h5", campaign.experiment, found.frf, origin)
    figures = GapFigures.of(found.report, found.corrected.nodes)
    save_gap(run / FIGURES, figures, found.report.signatures, record, origin)
    if not (run / "laws.h5").is_file():
        plain = found.plain
        save_laws(run / "laws.h5", plain.updated, plain.laws, plain.twin, origin)
    write_twin(run / TWIN, twin_file(campaign, found, based_on))
    if found.corrected.effects:
        save_corrected_laws(run / LAWS, campaign, found.corrected, found.twin.error, origin)
    else:
        (run / LAWS).unlink(missing_ok=True)
    write_json(run / GAP, record)
    return record


def save_corrected_laws(
    target: Path, campaign: Campaign, corrected: CorrectedTwin, error: float, origin: dict[str, Any]
) -> None:
    """Write laws and answers of a twin with effects, as a file that every verb takes for laws.h5."""
    density = campaign.experiment.plate.density
    frequency = corrected.frequency
    save_laws(
        target, corrected.updated, corrected.laws, TwinFrf(frequency, corrected.answers, error, density), origin
    )


def twin_file(campaign: Campaign, found: GapComparison, based_on: str | None) -> TwinFile:
    """Describe the twin that was issued; numbers to nine digits, standard deviations to four."""
    corrected, experiment = found.corrected, campaign.experiment
    laws = corrected.laws
    low, high = corrected.nodes.temperature[[0, -1]].tolist() if laws is None else laws.temperature_range
    material, sigma = material_of(corrected.nodes)
    return TwinFile(
        title=experiment.title,
        plate=experiment.plate,
        patch=experiment.patch,
        drive=experiment.drive,
        sensor=experiment.sensor,
        string=experiment.string,
        cable=experiment.cable,
        acquisition=experiment.acquisition,
        protocol=experiment.protocol,
        oven=experiment.oven,
        gain=_estimated(corrected.updated.gain, corrected.updated.sigma_gain, experiment.inputs[0].gain_unit),
        laws=TwinLaws(
            temperature_range=(_rounded(low), _rounded(high)),
            temperature=_column(corrected.nodes.temperature),
            youngs_modulus=_column(material.youngs_modulus),
            sigma_youngs_modulus=_column(sigma.youngs_modulus, 4),
            poisson_ratio=_column(material.poisson_ratio),
            sigma_poisson_ratio=_column(sigma.poisson_ratio, 4),
            loss_factor=_column(material.loss_factor),
            sigma_loss_factor=_column(sigma.loss_factor, 4),
        ),
        effect=tuple(
            TwinEffect(name=name, parameter={p.name: _estimated(p.value, p.sigma, p.unit) for p in values})
            for name, values in corrected.effects.items()
        ),
        basis=Basis(
            operators=operators_key(experiment, material_box(experiment.plate.material)),
            error=_rounded(found.twin.error, 4),
        ),
        origin=TwinOrigin(
            flexura=analysis.__version__,
            campaign=campaign.name,
            inputs=hashlib.sha256(json.dumps(sorted(campaign.hashes.items())).encode()).hexdigest(),
            verdict=found.report.verdict,
            based_on=based_on,
        ),
    )


def _estimated(value: float, sigma: float, unit: str) -> Estimated:
    return Estimated(value=_rounded(value), sigma=_rounded(sigma, 4), unit=unit)


def _column(values: NDArray[np.float64], digits: int = 9) -> tuple[float, ...]:
    return tuple(_rounded(float(value), digits) for value in values)


def _rounded(value: float, digits: int = 9) -> float:
    return float(f"{value:.{digits}g}")
