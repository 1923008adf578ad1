"""The twin of an updated run expects modes: named by their shapes, and refused where they do not belong."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import app.twins.expected_modes
from analysis.material import Material
from app.files.bad_file import ResultFileError
from app.twins.expected_modes import expected_modes

TEMPERATURE = np.array([20.0, 30.0, 40.0])


class CrossingTwin:
    """Three modes whose squares depend on Poisson's ratio, so that the last two cross."""

    instruments = SimpleNamespace(connected=(), across=lambda _, frequency: np.zeros((0, frequency.size)))
    plate = SimpleNamespace(capacitance=np.zeros(0))

    def __init__(self, dashpots: int = 0) -> None:
        self.dashpots = dashpots

    def state(self, laws: Any, _lines: Any) -> Any:
        return laws

    def solved(self, laws: Any, lines: Any) -> Any:
        ratio, loss = float(laws.poisson_ratio(laws.reference)), float(laws.loss_factor(laws.reference))
        squares = (2 * np.pi * np.array([100.0, 200.0 + 100.0 * (ratio - 0.3), 202.0])) ** 2
        order = np.argsort(squares)
        shapes = np.eye(3)[:, order].astype(complex)
        modal = SimpleNamespace(
            poles=squares[order] * (1 + 1j * loss), shapes=shapes, inverse=shapes.T, count=self.dashpots
        )
        composite = SimpleNamespace(coupling=np.zeros((3, 0)))
        return SimpleNamespace(modal=modal, basis=np.eye(3), composite=composite, frequency=np.array(lines))


def prepared(
    monkeypatch: pytest.MonkeyPatch,
    twin: Any,
    sweeps: int = 3,
    effects: dict[str, float] | None = None,
    *,
    settled: tuple[bool, ...] = (True, True, True),
    fit: bool = True,
) -> Any:
    material = Material(np.full(3, 2e9), np.array([0.30, 0.31, 0.36]), np.full(3, 0.05))
    updated = SimpleNamespace(temperature=TEMPERATURE, material=material, settled=np.array(settled))
    monkeypatch.setattr(app.twins.expected_modes, "load_updated", lambda _: (updated, None))
    monkeypatch.setattr(app.twins.expected_modes, "effects_in_laws", lambda _: effects or {})
    monkeypatch.setattr(app.twins.expected_modes, "load_pairing", lambda _: {"fit": fit})
    monkeypatch.setattr(app.twins.expected_modes, "campaign_twin", lambda *_: twin)
    return SimpleNamespace(
        sweeps=[SimpleNamespace(temperature=float(t)) for t in TEMPERATURE[:sweeps]],
        experiment=SimpleNamespace(protocol=SimpleNamespace(band=(50.0, 300.0))),
    )


def test_modes_that_cross_keep_their_columns(monkeypatch: pytest.MonkeyPatch) -> None:
    campaign = prepared(monkeypatch, CrossingTwin())
    poles = expected_modes(campaign, Path("laws.h5"), lambda *_: None).poles
    k = -(poles**2)
    f = np.sqrt(k.real) / (2 * np.pi)
    np.testing.assert_allclose(f, [[100.0, 200.0, 202.0], [100.0, 201.0, 202.0], [100.0, 206.0, 202.0]])
    np.testing.assert_allclose(k.imag / k.real, 0.05)


def test_other_sweeps_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    campaign = prepared(monkeypatch, CrossingTwin(), sweeps=2)
    with pytest.raises(ResultFileError, match="holds 3 sweeps, the campaign 2"):
        expected_modes(campaign, Path("laws.h5"), lambda *_: None)


def test_a_twin_with_dashpots_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    campaign = prepared(monkeypatch, CrossingTwin(dashpots=1))
    with pytest.raises(ResultFileError, match="the twin has dashpots"):
        expected_modes(campaign, Path("laws.h5"), lambda *_: None)


def test_laws_under_effects_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    campaign = prepared(monkeypatch, CrossingTwin(), effects={"clamp": 1.0})
    with pytest.raises(ResultFileError, match="those under clamp"):
        expected_modes(campaign, Path("laws.h5"), lambda *_: None)


def test_a_twin_that_did_not_settle_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    campaign = prepared(monkeypatch, CrossingTwin(), settled=(True, False, True))
    with pytest.raises(ResultFileError, match=r"at 30\.0 °C the fit of flexura update did not settle"):
        expected_modes(campaign, Path("laws.h5"), lambda *_: None)


def test_a_twin_whose_modes_do_not_pair_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    campaign = prepared(monkeypatch, CrossingTwin(), fit=False)
    with pytest.raises(ResultFileError, match="this twin is no fit"):
        expected_modes(campaign, Path("laws.h5"), lambda *_: None)
