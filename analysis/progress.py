"""How a long computation reports its progress."""

from collections.abc import Callable

Progress = Callable[[str, float], None]
"""Called with a stage's name and the share of it done, 0 to 1."""
