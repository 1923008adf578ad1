"""Poles and residues of FRFs."""
