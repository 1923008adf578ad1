"""The twin against recordings made by an independent solver, with that solver's own material."""

from pathlib import Path

import numpy as np
import pytest
from nptdms import TdmsFile
from scipy.interpolate import CubicSpline

from analysis.material import LocalLaws
from simulation.shell.electric_load import ElectricLoad
from simulation.twin.declared_plate import DeclaredPlate
from simulation.twin.instruments import Instruments
from simulation.twin.twin import Twin

FOLDER = Path(__file__).parents[3] / "shared" / "data" / "campaigns" / "pp-plate-nominal"
GAIN = 16.5103  # stated in the campaign's README

pytestmark = [
    pytest.mark.shared,
    pytest.mark.skipif(not FOLDER.is_dir(), reason="the recorded campaigns are not beside the checkout"),
]


def recorded(file):
    """Oven temperature, lines of the band clear of mains [Hz], H1 and its variance on them."""
    with TdmsFile.open(file) as tdms:
        groups = tdms.groups()
        step = groups[0]["drive"].properties["wf_increment"]
        spectra = [[np.fft.rfft(group[name][:].astype(float)) for name in ("drive", "S1")] for group in groups]
        oven = [tdms.properties[f"oven_temperature_{edge}"] for edge in ("start", "end")]
        frequency = np.fft.rfftfreq(groups[0]["drive"][:].size, step)
    ratio = np.array([response / drive for drive, response in spectra])
    clear = (frequency >= 100.0) & (frequency <= 1500.0) & (np.abs((frequency + 25.0) % 50.0 - 25.0) > 1.3)
    variance = ratio.var(axis=0, ddof=1) / len(ratio)
    return np.mean(oven), frequency[clear], ratio.mean(axis=0)[clear], variance[clear]


@pytest.mark.parametrize("step", [0, 10, 20, 30])
def test_twin_meets_the_recording_at_its_noise(nominal, step):
    """Nothing is fitted but the temperature, within three times the oven reading's noise."""
    twin = Twin(DeclaredPlate(nominal), Instruments.of_patches(0, (1,), ElectricLoad(305e3, 120e-12)))
    table = np.genfromtxt(FOLDER / "truth-laws.csv", delimiter=",", skip_header=1)
    laws = [CubicSpline(table[:, 0], table[:, k]) for k in (1, 2, 3)]
    oven, frequency, measured, variance = recorded(sorted((FOLDER / "sweeps").glob("*.tdms"))[step])

    def predicted(temperature):
        material = (float(law(temperature)) for law in laws)
        return GAIN * twin.frf(LocalLaws.of_material(*material, reference=float(temperature)), frequency)[0]

    temperature = oven
    for _ in range(4):
        here = predicted(temperature)
        slope = (predicted(temperature + 0.01) - here) / 0.01
        temperature += np.vdot(slope, measured - here).real / np.vdot(slope, slope).real
    assert abs(temperature - oven) < 0.12
    misfit = np.mean(np.abs(measured - predicted(temperature)) ** 2)
    # Three repeats give the variance itself to a per cent over three thousand lines.
    assert misfit < 1.06**2 * np.mean(variance)
