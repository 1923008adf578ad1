"""Values refuse nonsense when they are made, naming value, field, what it holds and what is allowed."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from analysis.channel import Footprint
from analysis.compensation.knots import PlacedTemperatures
from analysis.compensation.law_band import ContrastBand
from analysis.compensation.network import LowRankBank
from analysis.compensation.outcome import NetworkStudy
from analysis.compensation.tilted import TiltedContrast
from analysis.estimates import FittedLaws
from analysis.estimation.estimators import FrfEstimate
from analysis.estimation.impacts import HammerTest
from analysis.estimation.spectra import Spectra
from analysis.estimation.transfer import MeasuredTransfer
from analysis.focusing.fir import FirEnergy
from analysis.focusing.methods import MethodComparison
from analysis.focusing.panel_model import PanelModes
from analysis.focusing.pareto import ParetoCurve
from analysis.focusing.performance import Aim
from analysis.focusing.played import Played
from analysis.health.baseline import PanelLinearisation, SelfCheck
from analysis.health.evidence import SpanEstimate
from analysis.health.recording import DatedRecording, DateEquations, ExpectedResponse
from analysis.health.watch import HealthDate, HealthReport, NamedChange
from analysis.identification.measured import Measured
from analysis.material import Material, MaterialBox, MaterialLaws, MaterialSigma
from analysis.recordings.frf import Frf
from analysis.shapes.stabilization import StabilizationChart
from analysis.thermometry import Listener
from analysis.updated import Updated
from analysis.updating.normal_equations import SweepData
from analysis.weather.family import TiltFamily, WarmAnswer
from analysis.weather.judged import WeatherFields, WeatherJudgement
from app.files.acquisition.events import LatestRepeat
from app.files.results.gap_file import GapMap, Signatures
from app.files.results.laws_file import TwinFrf
from app.files.results.panel_files import Surfaces
from app.sound.listening import PlayedSignals
from app.watch.watched import MeasuredSweep
from drivers.hammer.hammer_rig import TriggerSettings
from drivers.hammer.judged_hit import HitJudge
from drivers.hammer.simulated import HandSettings

T, K, F = 3, 2, 4
WARMER = np.array([10.0, 20.0, 30.0])
LINES = np.array([100.0, 200.0, 300.0, 400.0])
ONE_NAN = np.array([1.0, np.nan, 1.0])
H = np.ones((K, F), dtype=complex)


def ones(*shape: int) -> Any:
    return np.ones(shape)


def hole(*shape: int) -> Any:
    """Ones and a NaN."""
    array = np.ones(shape)
    array.flat[-1] = np.nan
    return array


MATERIAL = Material(np.full(T, 2e9), np.full(T, 0.4), np.full(T, 0.05))
SIGMA = MaterialSigma(np.full(T, 1e7), np.full(T, 0.01), np.full(T, 0.001))
FAMILY = TiltFamily(WARMER, 20.0, ones(T, K, 8), ones(T, K, 8), ones(T, 2, K, 8), ones(T, 2, K, 8), ones(T, 2))
FRF = Frf(
    WARMER,
    ("up",) * T,
    ones(T),
    LINES,
    ones(T, K, F) + 0j,
    ones(T, K, F),
    ones(T, K, F),
    ones(F) > 2.0,
    ("S1", "S2"),
)
UPDATED = Updated(
    WARMER, MATERIAL, SIGMA, ones(T, 4, 4), 1.0, 0.1, ones(T), ones(T), ones(T), ones(T), ones(T) > 0.0
)
LAWS = MaterialLaws(
    np.array([0.0] * 4 + [60.0] * 4), np.tile([[21.0], [0.4], [-3.0]], (1, 4)), np.zeros((3, 4, 4)), (0.0, 60.0)
)
TABLE: list[tuple[Any, str, Any, str]] = [
    (
        MATERIAL,
        "youngs_modulus",
        np.array([2e9, -1e9, 2e9]),
        r"Material.youngs_modulus is -1e\+09 Pa; allowed: above",
    ),
    (MATERIAL, "youngs_modulus", ones(2), r"has shape \(3,\); allowed: \(T\) with T = 2 as in youngs_modulus"),
    (MATERIAL, "youngs_modulus", np.array([2e9, np.inf, 2e9]), "1 of 3 numbers are not finite"),
    (MATERIAL, "poisson_ratio", np.full(T, 7.0), "Material.poisson_ratio is 7; allowed: from -1 to 1"),
    (MATERIAL, "loss_factor", np.full(T, -2.0), "Material.loss_factor is -2; allowed: from 0"),
    (MATERIAL, "loss_factor", ONE_NAN, "Material.loss_factor is nan"),
    (SIGMA, "youngs_modulus", np.full(T, -1.0), "MaterialSigma.youngs_modulus is negative"),
    (SIGMA, "loss_factor", ones(T + 1), "MaterialSigma.loss_factor has shape"),
    (
        MaterialBox((1e9, 3e9), (0.3, 0.4), (0.01, 0.1)),
        "youngs_modulus",
        (3e9, 1e9),
        "must ascend; 3e.09 is followed",
    ),
    (MaterialBox((1e9, 3e9), (0.3, 0.4), (0.01, 0.1)), "poisson_ratio", (0.3, np.nan), "not finite"),
    (MaterialBox((1e9, 3e9), (0.3, 0.4), (0.01, 0.1)), "loss_factor", (0.0, 5.0), "loss_factor is 5; allowed"),
    (LAWS, "temperature_range", (60.0, 0.0), "temperature_range must ascend; 60 is followed by 0"),
    (LAWS, "knots", np.arange(7.0), r"knots has shape \(7,\); allowed: \(n\+4\) with n = 4 as in coefficients"),
    (LAWS, "knots", np.array([60.0] * 4 + [0.0] * 4), "knots must ascend"),
    (LAWS, "coefficients", hole(3, 4), "coefficients: 1 of 12 numbers are not finite"),
    (LAWS, "covariance", ones(3, 4, 3), r"covariance has shape \(3, 4, 3\)"),
    (FittedLaws(WARMER, ones(T, 3), ones(T, 3)), "value", ones(T, 2), "FittedLaws.value has shape"),
    (FittedLaws(WARMER, ones(T, 3), ones(T, 3)), "value", hole(T, 3), "not finite"),
    (UPDATED, "misfit", ones(T - 1), "Updated.misfit has shape"),
    (UPDATED, "material", Material(ones(2), ones(2), ones(2)), "Updated.material.youngs_modulus has shape"),
    (UPDATED, "gain", np.nan, "Updated.gain: 1 of 1 numbers are not finite"),
    (FRF, "level", ones(T - 1), "Frf.level has shape"),
    (FRF, "direction", ("up",), "Frf.direction has shape"),
    (FRF, "h", ones(T, F, K) + 0j, "Frf.h has shape"),
    (FRF, "h", hole(T, K, F) + 0j, "Frf.h: 1 of 24 numbers are not finite"),
    (FRF, "frequency", LINES[::-1], "Frf.frequency must ascend; 400 is followed by 300"),
    (FRF, "variance", -ones(T, K, F), "Frf.variance is -1; allowed: from 0"),
    (FRF, "temperature", ONE_NAN, "Frf.temperature: 1 of 3"),
    (Measured(LINES, H), "frequency", LINES[::-1], "Measured.frequency must ascend"),
    (Measured(LINES, H), "h", ones(K, F + 1) + 0j, "Measured.h has shape"),
    (Measured(LINES, H), "h", hole(K, F) + 0j, "Measured.h: 1 of 8"),
    (Measured(LINES, H), "variance", ones(F, K), "Measured.variance has shape"),
    (
        MeasuredTransfer("a", "1:+3", "2:+3", "unknown", LINES, H[0]),
        "frequency",
        LINES - 100.0,
        "allowed: above 0 Hz",
    ),
    (
        MeasuredTransfer("a", "1:+3", "2:+3", "unknown", LINES, H[0]),
        "coherence",
        ones(F - 1),
        "coherence has shape",
    ),
    (
        FrfEstimate(LINES, ones(K, 1, F) + 0j, None, ones(K, F), 3.0),
        "h",
        ones(1, K, F) + 0j,
        "coherence has shape",
    ),
    (
        Spectra(LINES, ones(F, 1, 1) + 0j, ones(F, K, 1) + 0j, ones(F, K), 3.0),
        "g_uu",
        ones(F, 1, 2) + 0j,
        "g_uu has",
    ),
    (Spectra(LINES, ones(F, 1, 1) + 0j, ones(F, K, 1) + 0j, ones(F, K), 3.0), "averages", 0.0, "averages is 0"),
    (SweepData(LINES, H, ones(K, F)), "weight", -ones(K, F), "SweepData.weight is -1"),
    (SweepData(LINES, H, ones(K, F)), "h", hole(K, F) + 0j, "SweepData.h: 1 of 8"),
    (TwinFrf(LINES, ones(T, K, F) + 0j, 1e-4, 900.0), "density", -900.0, "TwinFrf.density is -900 kg/m3"),
    (TwinFrf(LINES, ones(T, K, F) + 0j, 1e-4, 900.0), "h", hole(T, K, F) + 0j, "TwinFrf.h: 1 of 24"),
    (Footprint((0.1, 0.1)), "radius", -1e-3, "Footprint.radius is -0.001 m"),
    (Footprint((0.1, 0.1)), "mass", np.nan, "Footprint.mass is nan kg"),
    (Footprint((0.1, 0.1)), "point", (0.1, np.inf), "Footprint.point: 1 of 2"),
    (Aim(ones(T, F), ones(T, F), ones(T, F) + 0j), "response", ones(F, T) + 0j, "Aim.response has shape"),
    (FirEnergy(*4 * (ones(T, 6),)), "after", ones(T, 5), "FirEnergy.after has shape"),
    (
        MethodComparison(("a", "b"), (2e9, 0.4, 0.05), LINES, ones(2, F), ones(2, F)),
        "contrast",
        ones(3, F),
        r"contrast has shape \(3, 4\); allowed: \(m, F\) with m = 2 as in methods",
    ),
    (PanelModes(ones(5) + 0j, ones(9, 5), ones(5, 6)), "coupling", ones(6, 5), "PanelModes.coupling has shape"),
    (PanelModes(ones(5) + 0j, ones(9, 5), ones(5, 6)), "shapes", hole(9, 5), "PanelModes.shapes: 1 of 45"),
    (ParetoCurve(20.0, *7 * (ones(3),)), "drive", ones(2), "ParetoCurve.drive has shape"),
    (
        Played(("a",), ones(1), LINES, ones(1, F), LINES, ones(1, F), ones(1), ones(1)),
        "frequency",
        LINES[::-1],
        "Played.frequency must ascend",
    ),
    (ContrastBand(WARMER, ones(T, 2), ones(T, 2), ones(T, 2), 0.9, 100), "share", 90.0, "share is 90; allowed"),
    (
        ContrastBand(WARMER, ones(T, 2), ones(T, 2), ones(T, 2), 0.9, 100),
        "draws",
        0,
        "draws is 0; allowed: from 1",
    ),
    (
        TiltedContrast(ones(1), ones(1, T), ones(1, T, 4), ones(1, T, 2), ones(1, T, 4, 2), ones(1, T, 4, 2)),
        "fed_mean",
        ones(1, T, 3, 2),
        "TiltedContrast.fed_mean has shape",
    ),
    (WarmAnswer(H[:, :, None], ones(K, K, F) + 0j), "charge", ones(K, 1, F), "WarmAnswer.charge has shape"),
    (FAMILY, "slope", ones(T, 1, K, 8), "TiltFamily.slope has shape"),
    (FAMILY, "temperature", WARMER[::-1], "must ascend"),
    (
        WeatherFields(WARMER, ones(T, 9), ones(T, 1), ones(1, 2), ("a",)),
        "temperature",
        hole(T, 9),
        "WeatherFields.temperature: 1 of 27",
    ),
    (
        WeatherJudgement(
            ("one",),
            ("a",),
            ones(1, 2),
            WARMER,
            ones(T, 3),
            ones(T, 1),
            ones(1, T, 3),
            ones(1, T, F),
            ones(T, F),
            ones(1, T, 2),
            ones(2),
            5.0,
        ),
        "contrast",
        ones(2, T, F),
        "WeatherJudgement.contrast has shape",
    ),
    (LowRankBank(WARMER, ones(T, 2), ones(2, 6, 8), ones(6, 8)), "temperature", WARMER[::-1], "must ascend"),
    (LowRankBank(WARMER, ones(T, 2), ones(2, 6, 8), ones(6, 8)), "filters", hole(2, 6, 8), "filters: 1 of 96"),
    (PlacedTemperatures(WARMER, WARMER, 0.1, 0.2), "equidistant", WARMER[:2], "equidistant has shape"),
    (NetworkStudy(ones(2), ones(2), ones(2, 6), ones(2)), "spacing", ones(3), "NetworkStudy.spacing has shape"),
    (StabilizationChart(ones(4), LINES, ones(4), ones(4)), "stable", 3.0 * ones(4), "stable is 3; allowed"),
    (Listener(WARMER, ones(T, 1, 8) + 0j, 1e3, (1.0, 2.0), 8), "temperature", WARMER[::-1], "must ascend"),
    (
        GapMap(np.arange(F + 1.0), WARMER, ones(T), ("up",) * T, ("S1",), ones(T, 1, F), ones(T, 1, F)),
        "edges",
        np.arange(F + 0.0),
        "GapMap.sigma has shape",
    ),
    (
        Signatures(("mass",), ones(1, T, 1, F), ones(1) > 0.0),
        "effects",
        ("mass", "tilt"),
        "Signatures.sigma has shape",
    ),
    (
        LatestRepeat(0, 0, "20 °C", ("drive", "S1"), ones(2, 9), ones(2) > 2.0, 1e3, 5.0),
        "sample_rate",
        0.0,
        "LatestRepeat.sample_rate is 0 Hz; allowed: above 0 Hz",
    ),
    (TriggerSettings(0.1, 0.02, 1.0), "level", 0.0, "TriggerSettings.level is 0 V; allowed: above 0 V"),
    (TriggerSettings(0.1, 0.02, 1.0), "duration", 0.01, "more than the pretrigger"),
    (HandSettings(20.0, 0.2, 4e-4, 0.1, 0.1, 1.0, 1.0), "double_hits", 1.5, "double_hits is 1.5; allowed: from 0"),
    (HandSettings(20.0, 0.2, 4e-4, 0.1, 0.1, 1.0, 1.0), "overloads", 0.95, "together at most 1"),
    (HitJudge(HammerTest(2.0, 0.02, 1.0), (0.01,), ("hammer",), 4.9), "volts", (0.0,), "above 0"),
    (HitJudge(HammerTest(2.0, 0.02, 1.0), (0.01,), ("hammer",), 4.9), "test", HammerTest(), "must be given"),
    (HammerTest(), "coupling", 0.0, "coupling 0 Hz; above 0 to 100 allowed"),
    (Surfaces(WARMER, ones(T, 6, 8), 4e3), "taps", hole(T, 6, 8), "Surfaces.taps: 1 of 144"),
    (PlayedSignals(ones(1, 9), ones(9), 1e3), "response", ones(8), "PlayedSignals.response has shape"),
    (
        ExpectedResponse(20.0, ones(1, K, F) + 0j, ones(2, 1, K, F) + 0j, ones(2), ones(3, 1, K, F) + 0j),
        "nuisance_sigma",
        ones(3),
        "ExpectedResponse.nuisance_sigma has shape",
    ),
    (
        PanelLinearisation(20.0, ones(1, K, F) + 0j, ones(2, 1, K, F) + 0j, ones(2), ones(3, 1, K, F) + 0j),
        "transfer",
        hole(1, K, F) + 0j,
        "PanelLinearisation.transfer: 1 of 8",
    ),
    (DateEquations(np.eye(2), ones(2), 1.0, 1, 20.0, 0.1, ones(2)), "gradient", ones(3), "gradient has shape"),
    (SelfCheck(ones(2), 1.0, 1.0), "variance", -ones(2), "SelfCheck.variance is -1; allowed: from 0"),
    (SpanEstimate(1, ones(2), ones(2)), "span", 0, "SpanEstimate.span is 0; allowed: from 1"),
    (HealthDate("week 1", 20.0), "sigma", -1.0, "HealthDate.sigma is -1; allowed: from 0"),
    (NamedChange("mass", 0.9, (), None, "week 1", 1), "probability", 1.1, "probability is 1.1; allowed"),
    (HealthReport(1e-3, 4.8, 1.2, (), None, 1.0, 0), "rate", 0.0, "HealthReport.rate is 0; allowed: above 0"),
    (MeasuredSweep(0, "up", 20.0, LINES, H, ones(K, F)), "h", H[:, 1:], "MeasuredSweep.h has shape"),
]


@pytest.mark.parametrize(
    ("value", "field", "nonsense", "told"), TABLE, ids=[f"{type(row[0]).__name__}-{row[1]}" for row in TABLE]
)
def test_nonsense_is_refused(value: Any, field: str, nonsense: Any, told: str) -> None:
    with pytest.raises(ValueError, match=told):
        replace(value, **{field: nonsense})


def test_a_date_without_sweeps_is_none() -> None:
    with pytest.raises(ValueError, match="'week 1': no sweeps; at least one input wanted"):
        DatedRecording("week 1", 20.0, ())


def test_a_single_material_is_one() -> None:
    with pytest.raises(ValueError, match="youngs_modulus"):
        Material(E := np.array([-1e9]), E, E)


@pytest.mark.parametrize("make", [lambda: replace(FRF, shift=None), lambda: replace(SIGMA, loss_factor=ONE_NAN)])
def test_what_may_be_lacking_may_be(make: Callable[[], Any]) -> None:
    make()
