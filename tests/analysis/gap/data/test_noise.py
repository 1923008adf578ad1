"""The stated noise is checked against the data before anything is believed."""

from dataclasses import replace

import numpy as np
import pytest

from analysis.gap.data.preparation import prepare
from analysis.recordings.h1 import repeats_dof
from analysis.recordings.noise_power import noise_power


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


def from_repeats(toy, seed, *, repeats=6, factor=1.0):
    """Return a campaign with its variance from repeats, times a factor, and this variance over the true one."""
    frf, rig = toy.record(temperatures=(10.0, 30.0), directions=("up",), channels=1, spacing=4.0, seed=seed)
    dof = repeats_dof(repeats)
    drawn = np.random.default_rng(seed + 100).chisquare(max(dof, 1), frf.variance.shape) / max(dof, 1)
    variance = np.array(
        [
            [noise_power(*one, frf.excluded) for one in zip(*sweep, strict=True)]
            for sweep in zip(frf.variance * drawn, frf.h, strict=True)
        ]
    )
    over_true = factor * float((variance / frf.variance).mean())
    variance *= factor
    return replace(frf, variance=variance, repeats_dof=np.full(2, dof)), rig, over_true


def test_repeats_and_neighbouring_lines_together_know_the_noise_better_than_the_lines_alone(toy):
    together, alone, stated = [], [], []
    for seed in range(24):
        frf, rig, over_true = from_repeats(toy, seed)
        _, noise = prepare(frf, rig, toy.updated(frf))
        _, lines_only = prepare(replace(frf, repeats_dof=None), rig, toy.updated(frf))
        together.append(noise.ratio[0] * over_true - 1.0)
        alone.append(lines_only.ratio[0] * over_true - 1.0)
        stated.append(np.sqrt(2.0 / noise.dof))
    assert np.sqrt(np.mean(np.square(together))) < 0.7 * np.sqrt(np.mean(np.square(alone)))
    assert np.sqrt(np.mean(np.square(together))) == pytest.approx(np.mean(stated), rel=0.4)


def test_repeats_that_disagree_with_the_lines_are_not_used(toy):
    frf, rig, _ = from_repeats(toy, 0, factor=0.6)
    _, noise = prepare(frf, rig, toy.updated(frf))
    _, lines_only = prepare(replace(frf, repeats_dof=None), rig, toy.updated(frf))
    assert noise.ratio == pytest.approx(lines_only.ratio, rel=1e-12)
    assert noise.dof == lines_only.dof
    assert noise.ratio[0] == pytest.approx(1.0 / 0.6, rel=0.2)


def test_one_repeat_tells_nothing_of_the_noise(toy):
    frf, rig, _ = from_repeats(toy, 0, repeats=1)
    assert not frf.repeats_dof.any()
    _, noise = prepare(frf, rig, toy.updated(frf))
    _, lines_only = prepare(replace(frf, repeats_dof=None), rig, toy.updated(frf))
    assert noise.ratio == pytest.approx(lines_only.ratio, rel=1e-12)
