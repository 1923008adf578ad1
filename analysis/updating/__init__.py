"""Model updating."""
