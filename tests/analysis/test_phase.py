import numpy as np

from analysis.drawn_curves import drawn_phase

F = np.arange(1.0, 9.0)


def test_lines_end_where_the_phase_leaps() -> None:
    degrees = np.array([100.0, 170.0, -170.0, -100.0, 0.0, -179.0, 179.0, 179.5])
    frequency, phase = drawn_phase(F, np.exp(1j * np.radians(degrees)))
    kept = np.isfinite(phase)
    np.testing.assert_allclose(phase[kept], degrees)
    np.testing.assert_allclose(frequency[kept], F)
    np.testing.assert_allclose(frequency[~kept], [2.5, 6.5])
    assert (np.abs(np.diff(phase))[np.isfinite(np.diff(phase))] <= 180.0).all()


def test_noise_has_no_phase() -> None:
    h = np.array([1.0, 1.0, 0.03, -0.03, 0.03j, -0.01, 1.0, 1.0]).astype(complex)
    _, phase = drawn_phase(F, h, np.full(8, 0.02))
    np.testing.assert_array_equal(np.isfinite(phase), np.abs(h) > 0.04)
    assert np.isfinite(drawn_phase(F, h)[1]).sum() == 8
