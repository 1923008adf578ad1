"""Plates that are not exactly as declared, and small causes that nobody tells."""

import copy

import numpy as np
import pytest

from app.blind_trial.experiments import draw_experiments
from app.blind_trial.making import NUISANCES, draw_nuisances
from app.blind_trial.plates import CAREFUL, LEAST_AREA, PlateKind, as_built, as_it_is, as_read, draw_plate
from app.blind_trial.specimen import Specimen


@pytest.mark.parametrize("driven", ["patch", "exciter"])
@pytest.mark.parametrize("rectangular", [True, False])
def test_what_is_built_scatters_about_the_declaration_as_a_careful_workshop_does(driven, rectangular):
    declared = draw_plate(np.random.default_rng(3), driven, rectangular=rectangular)
    built = [as_built(declared, np.random.default_rng(seed)) for seed in range(300)]

    def deviation(value):
        return np.std([np.subtract(value(one), value(declared)) for one in built], axis=0)

    np.testing.assert_allclose(deviation(lambda k: k.plate.thickness / declared.plate.thickness), 0.005, rtol=0.15)
    np.testing.assert_allclose(deviation(lambda k: k.plate.mass / declared.plate.mass), 0.001, rtol=0.15)
    np.testing.assert_allclose(deviation(lambda k: np.subtract(*k.plate.bounds[::-1])), CAREFUL.length, rtol=0.15)
    if driven == "patch":
        np.testing.assert_allclose(deviation(lambda k: k.patches[0].center), CAREFUL.patch_place, rtol=0.15)
        np.testing.assert_allclose(deviation(lambda k: k.patches[0].size), CAREFUL.patch_size, rtol=0.15)
    else:
        np.testing.assert_allclose(deviation(lambda k: k.drives[0].point), CAREFUL.transducer_place, rtol=0.15)
        np.testing.assert_allclose(deviation(lambda k: k.sensors[0].mass), CAREFUL.transducer_mass, rtol=0.15)
        areas = [(one.sensors[0].contact_radius / declared.sensors[0].contact_radius) ** 2 for one in built]
        assert min(areas) == pytest.approx(LEAST_AREA)
        np.testing.assert_allclose(np.median(areas), 1.0, atol=0.25)
        assert all(one.sensors[1].radius is None for one in built)  # a laser's spot
    assert all(one.inputs == declared.inputs and one.band == declared.band for one in built)


def test_laws_over_readings_are_the_plates_own_at_what_the_oven_really_has(experiment):
    laws = experiment.simulation.laws
    read = as_read(laws, 22.0, np.random.default_rng(1)).laws()
    offset, slope = np.random.default_rng(1).normal(0.0, [CAREFUL.oven_offset, CAREFUL.oven_slope])
    reading = np.linspace(0.0, 60.0, 13)
    true = 22.0 + (1.0 + slope) * (reading - 22.0) + offset
    seen, own = read.at(reading), laws.laws().at(true)
    np.testing.assert_allclose(seen.youngs_modulus, own.youngs_modulus, rtol=1e-4)
    np.testing.assert_allclose(seen.loss_factor, own.loss_factor, rtol=1e-3)


def test_the_specimen_is_as_built_and_the_campaign_as_declared(kind: PlateKind, operators):
    rng = np.random.default_rng(4)
    again = copy.deepcopy(rng)
    built = as_built(kind, np.random.default_rng(9))
    experiments = draw_experiments(rng, kind, "plate", ("up",), (1.0,))
    real = as_it_is(draw_experiments(again, built, "plate", ("up",), (1.0,)), rng)
    specimen = Specimen.of(experiments, operators, real)
    assert specimen.experiments[0].plate == kind.plate
    assert specimen.declared.plate == built.plate
    assert specimen.true_laws == experiments[0].simulation.laws
    assert specimen.true_laws.temperature != specimen.simulations[0].laws.temperature
    assert specimen.driven.tolist() == Specimen.of(experiments, operators).driven.tolist()


@pytest.mark.slow
def test_nuisances_scatter_the_resonances_as_much_as_wanted_and_make_effects_smaller(yard):
    rng = np.random.default_rng(5)
    for wanted in (0.001, 0.003):
        found = draw_nuisances(wanted, ("suspension",), yard, rng)
        assert found.scatter == pytest.approx(wanted, rel=0.3)
        assert set(found.effects) <= set(NUISANCES) - {"suspension"}
        signal = yard.signal({"point_mass": {"mass": 2e-4}})
        assert yard.beside(found.effects).size(signal) < 0.5 * yard.size(signal)
    assert draw_nuisances(0.0, (), yard, rng).effects == {}
