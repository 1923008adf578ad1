"""The stated noise is checked against the data before anything is believed."""

from dataclasses import replace

import numpy as np
import pytest

from analysis.gap.data.preparation import prepare


@pytest.mark.parametrize("stated", [0.7, 1.5])
def test_a_wrong_noise_is_found_said_and_mended(toy, stated):
    _, noise = toy.prepared(stated=stated, temperatures=(10.0, 30.0))
    assert np.sqrt(noise.ratio) == pytest.approx(1.0 / stated, rel=0.02)
    assert len(noise.notes) == 2
    assert f"{np.sqrt(noise.ratio[0]):.2f} times" in noise.notes[0]


def test_a_right_noise_is_not_talked_about(toy):
    sweeps, noise = toy.prepared(temperatures=(10.0, 30.0))
    assert noise.notes == ()
    assert noise.ratio == pytest.approx(1.0, abs=0.03)
    within = sum(s.chi2_within.sum() for s in sweeps.compressed)
    assert within / noise.dof == pytest.approx(1.0, abs=1e-9)


def test_a_noise_far_off_is_refused_with_its_number(toy):
    with pytest.raises(ValueError, match=r"S1.*0\.0\d+ times the stated"):
        toy.prepared(stated=5.0, temperatures=(10.0,))


def test_noise_that_belongs_to_other_sweeps_is_refused(toy):
    frf, rig = toy.record(temperatures=(10.0, 20.0, 30.0))
    variance = frf.variance.copy()
    variance[::2] *= 3.0
    with pytest.raises(ValueError, match="between sweeps"):
        prepare(replace(frf, variance=variance), rig, toy.updated(frf))


def test_lines_without_variance_are_refused(toy):
    frf, rig = toy.record(temperatures=(10.0,))
    with pytest.raises(ValueError, match="at least two repeats"):
        prepare(replace(frf, variance=0.0 * frf.variance), rig, toy.updated(frf))


def test_a_needle_between_the_nodes_is_a_feature_and_no_noise(toy):
    def needle(frequency, temperature):
        return 0.02 / (1.0 + 1j * (frequency - 1190.0) / 0.4)

    _, quiet = toy.prepared(temperatures=(10.0, 30.0))
    _, noise = toy.prepared(temperatures=(10.0, 30.0), extra=needle)
    assert noise.ratio == pytest.approx(quiet.ratio, rel=0.12)  # its skirts reach into the neighbouring blocks
    seen = noise.sharp.sum((0, 1))
    assert seen.max() > 0.999 * seen.sum()
    assert noise.z(1000.0, 1000.0) > 10.0 > abs(quiet.z(1000.0, 1000.0))
