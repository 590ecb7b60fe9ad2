"""Vibration at named points of the body, as it is measured there, and its severity."""
