"""Spatio-temporal inverse filtering."""
