"""The modes that the twin of an updated run expects in every sweep of its campaign."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from analysis.identification.over_temperature.expected_modes import ExpectedModes
from analysis.material import LocalLaws
from analysis.progress import Progress
from analysis.recordings.frf_campaign import AnyCampaign
from app.files.bad_file import ResultFileError
from app.files.results.laws_file import effects_in_laws, load_pairing, load_updated
from app.twins.campaign_twin import campaign_twin
from simulation.twin.declared_plate import DeclaredPlate
from simulation.twin.loaded_modes import LoadedModes
from simulation.twin.local_solution import LocalSolution
from simulation.twin.twin import Twin


def expected_modes(campaign: AnyCampaign, laws: Path, report: Progress) -> ExpectedModes:
    """Poles of the campaign's twin, with its patches connected as in the measurement.

    The material is that which ``flexura update`` found for every sweep.

    Parameters
    ----------
    campaign : AnyCampaign
        The one that was updated.
    laws : Path
        ``laws.h5`` of its run folder.
    report : Progress
        Called with the stage's name and the share done, if the twin has to be made.

    Raises
    ------
    ResultFileError
        If the file cannot be read, other sweeps were updated, the laws are those under effects, or the update
        itself says that it did not settle or that its modes do not pair.
    """
    if effects := effects_in_laws(laws):
        raise ResultFileError(
            f"{laws}: its laws are those under {', '.join(effects)} (flexura update --twin), and the modes to "
            "expect are the plain twin's: update without --twin into another run folder, and name that"
        )
    updated, _ = load_updated(laws)
    if not updated.settled.all():
        t = float(updated.temperature[np.flatnonzero(~updated.settled)[0]])
        raise ResultFileError(
            f"{laws}: at {t:.1f} °C the fit of flexura update did not settle, so its modes mean nothing: "
            "identify without --twin, or correct the declaration and update again"
        )
    pairing = load_pairing(laws)
    if pairing is not None and not pairing["fit"]:
        raise ResultFileError(
            f"{laws}: flexura update says that this twin is no fit: its modes do not pair with those measured. "
            "Identify without --twin, or correct the declaration and update again"
        )
    temperature = np.array([sweep.temperature for sweep in campaign.sweeps])
    if temperature.shape != updated.temperature.shape or np.abs(temperature - updated.temperature).max() > 1e-3:
        raise ResultFileError(
            f"{laws}: holds {len(updated.temperature)} sweeps, the campaign {len(temperature)}, or others: "
            "a sweep was left out, more were measured since, or this is another campaign's. Identify without "
            "--twin, or update this campaign"
        )
    twin, material = campaign_twin(campaign.experiment, report), updated.material
    lines = np.asarray(campaign.experiment.protocol.band, dtype=np.float64)
    constants = zip(
        material.youngs_modulus, material.poisson_ratio, material.loss_factor, temperature, strict=True
    )
    found = []
    for modulus, ratio, loss, reference in constants:
        here = LocalLaws.of_material(float(modulus), float(ratio), float(loss), reference=float(reference))
        found.append(twin.solved(twin.state(here, lines), lines))
    modes = [_loaded(twin, solved, laws) for solved in found]
    shapes = [solved.basis @ one.shapes for solved, one in zip(found, modes, strict=True)]
    return ExpectedModes(_named([one.poles for one in modes], shapes, temperature))


def _loaded(twin: Twin[DeclaredPlate], solved: LocalSolution, laws: Path) -> LoadedModes:
    """Modes of the plate with its patches connected, as measured."""
    if solved.modal is None or solved.modal.count:
        raise ResultFileError(
            f"{laws}: the twin has dashpots, or its stiffness changes along the band: modes to expect are not "
            "known. Identify without --twin"
        )
    return LoadedModes.of(solved, solved.modal, twin.instruments, twin.plate.capacitance)


def _named(
    poles: list[NDArray[np.complex128]], shapes: list[NDArray[np.complex128]], temperature: NDArray[np.float64]
) -> NDArray[np.complex128]:
    """Poles (T, J), a column for one mode: from each temperature to the next, modes go by their shapes.

    Parameters
    ----------
    poles : list of (m,) ndarray
        rad/s, by ascending magnitude.
    shapes : list of (r, m) ndarray
        In coordinates common to all temperatures.
    temperature : (T,) ndarray
        Degrees Celsius.

    Returns
    -------
    (T, J) ndarray
    """
    shapes = [shape / np.linalg.norm(shape, axis=0) for shape in shapes]
    count = min(len(row) for row in poles)
    row = np.arange(count)
    named = np.empty((len(poles), count), dtype=complex)
    before = None
    for t in np.argsort(temperature, kind="stable"):
        if before is not None:
            alike = np.abs(before.conj().T @ shapes[t]) ** 2
            row = linear_sum_assignment(-alike)[1]
        named[t], before = poles[t][row], shapes[t][:, row]
    return named
