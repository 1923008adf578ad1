"""Frequency of the mains: what is accepted wherever it is stated."""

MAINS_RANGE = (10.0, 400.0)
"""Hz: from below the 16.7 of railways to the 400 of aircraft."""


def require_mains(mains: float) -> None:
    """Raise ValueError for a frequency, Hz, that no mains have."""
    low, high = MAINS_RANGE
    if not low <= mains <= high:
        raise ValueError(f"mains {mains:g} Hz: {low:g} to {high:g} allowed")
