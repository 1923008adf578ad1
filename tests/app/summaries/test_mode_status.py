"""What a table of modes says behind each: status, and what speaks against the numbers of a mode that is kept."""

import pytest

from analysis.identification.judgement.status import NOT_ONE_POLE
from app.summaries.modes import mode_table


@pytest.mark.parametrize(
    ("status", "reason", "said"),
    [
        ("kept", "BIC would rise by 70 without it; found again in 3 of 3 refits", "kept, confirmed"),
        ("weak", "damping not known", "weak, confirmed: damping not known"),
        (
            "kept",
            f"BIC would rise by 70 without it{NOT_ONE_POLE.format(2.9)}; found again in 3 of 3 refits",
            f"kept, confirmed{NOT_ONE_POLE.format(2.9)}",
        ),
    ],
)
def test_a_kept_mode_that_is_not_one_pole_says_so(status: str, reason: str, said: str) -> None:
    """Two modes 1.4 Hz apart, lines 1 Hz: 144.421 ± 0.027 Hz, kept, confirmed, and the doubt in modes.csv only."""
    numbers = dict.fromkeys(
        ("frequency_hz", "sigma_frequency_hz", "damping_ratio", "sigma_damping_ratio", "loss_factor"), 0.1
    )
    mode = {**numbers, "status": status, "confirmation": "confirmed", "reason": reason, "overlaps_hz": None}
    assert mode_table("", [mode]).rows[0][-1] == said
