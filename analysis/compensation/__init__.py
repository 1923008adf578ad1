"""Filters at any temperature."""
