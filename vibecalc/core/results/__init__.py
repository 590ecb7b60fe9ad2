"""Quantities and their one description, in memory and on disk, and their comparison."""
