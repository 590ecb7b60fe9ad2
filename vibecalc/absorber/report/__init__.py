"""Absorbers in the report."""
