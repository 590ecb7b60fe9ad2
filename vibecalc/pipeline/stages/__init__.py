"""Thin adapters between a case and the stage functions, one file per stage."""
