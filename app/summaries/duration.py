"""A time in words."""


def duration(seconds: float) -> str:
    """Return hours and minutes, or seconds where it is less than two minutes."""
    if seconds < 120.0:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60.0)
    return f"{minutes // 60} h {minutes % 60:02d} min" if minutes >= 60 else f"{minutes} min"
