"""Lines too far apart for the resonances are reported, with the length of record that is enough."""

from analysis.protocol.objections import unresolved


def test_polymers_are_resolved_and_metals_are_told_how_long_to_record() -> None:
    assert unresolved((100.0, 1600.0), 0.4, 0.05) == ()
    (said,) = unresolved((100.0, 1600.0), 0.4, 1e-3)
    assert "0.4 Hz apart" in said
    assert "record for 5 s or longer" in said  # two lines over the 0.4 Hz of a resonance at 400 Hz
