"""Torsional vibration of shaft lines."""
