"""The gap workflow (being built)."""
