"""Declaration check: comparison of the declared plate with one sweep before its twin is built; takes seconds."""

import numpy as np

from analysis.declaration.plate_material import KINDS, material_box
from analysis.experiment import Experiment
from analysis.geometry.fault import GeometryError
from analysis.progress import Progress
from analysis.recordings.frf import Frf
from analysis.updating.modulus_scan import ModulusScan, scan_modulus, scanned_box
from analysis.updating.update import middle_sweep
from app.files.bad_file import ResultFileError
from simulation.reduction.coarse_plate import CoarsePlate

STAGE = "checking the declaration"


def check_declaration(experiment: Experiment, frf: Frf, report: Progress) -> tuple[str, ...]:
    """Compare the resonances of one sweep with those of the declared plate.

    Parameters
    ----------
    report : callable
        Called with a stage's name and the share of it done.

    Returns
    -------
    tuple of str
        Notes on doubtful declarations.

    Raises
    ------
    ResultFileError
        Where two sweeps, the middle one and the coldest or warmest, agree with no material in the declared ranges,
        but well with one outside.
    """
    report(STAGE, 0.0)
    box = material_box(experiment.plate.material)
    try:
        model = CoarsePlate.of(experiment, scanned_box(box))
    except (RuntimeError, GeometryError, np.linalg.LinAlgError):
        return ()  # if the check cannot be made, updating continues
    frf = frf.of_source(frf.driving[0])
    used, middle = ~frf.excluded, middle_sweep(frf)
    report(STAGE, 0.4)
    scans: dict[int, ModulusScan] = {}
    for sweep in dict.fromkeys((middle, int(frf.temperature.argmin()), int(frf.temperature.argmax()))):
        scans[sweep] = scan_modulus(model, frf.frequency[used], frf.h[sweep][:, used], box)
        if not scans[sweep].outside or len(scans) == 2:
            break
    report(STAGE, 1.0)
    if all(scan.far_outside for scan in scans.values()):
        raise ResultFileError(sentence(experiment, float(frf.temperature[middle]), scans[middle]))
    if all(scan.outside for scan in scans.values()):
        return (sentence(experiment, float(frf.temperature[middle]), scans[middle]),)
    return ()


def sentence(experiment: Experiment, temperature: float, scan: ModulusScan) -> str:
    """Describe what was declared, what the resonances suggest, and what to change.

    Parameters
    ----------
    temperature : float
        Of the sweep, degrees Celsius.
    """
    plate = experiment.plate
    low, high = material_box(plate.material).youngs_modulus
    ratio = scan.modulus / float(np.sqrt(low * high))
    # at constant mass, frequencies are proportional to the root of E h**3
    thinnest, middle, thickest = (
        1e3 * plate.thickness * (scan.modulus / e) ** (1.0 / 3.0) for e in (high, np.sqrt(low * high), low)
    )
    return (
        f"thickness {1e3 * plate.thickness:.3g} mm declared; the resonances at {temperature:.0f} °C say "
        f"{middle:.3g} mm ({thinnest:.2g} to {thickest:.2g} mm for E of {high / 1e9:.3g} to {low / 1e9:.3g} GPa), "
        f"or {ratio:.3g} times the modulus, {scan.modulus / 1e9:.3g} GPa. Check thickness, mass, lengths and "
        f"units; if they are right, declare in [plate.material] {_material(scan.modulus)}"
    )


def _material(modulus: float) -> str:
    kinds = [
        f'"{name}"' for name, box in KINDS.items() if box.youngs_modulus[0] <= modulus <= box.youngs_modulus[1]
    ]
    numbers = f"youngs_modulus = [{0.7 * modulus:.1e}, {1.4 * modulus:.1e}], with poisson_ratio and loss_factor"
    return f"kind = {' or '.join(kinds)}, or {numbers}" if kinds else numbers
