"""Stages of the roll: from a case to recorded results."""
