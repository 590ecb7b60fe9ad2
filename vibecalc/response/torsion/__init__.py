"""Torsional vibration of shaft lines: modes, forced motion, transients."""
