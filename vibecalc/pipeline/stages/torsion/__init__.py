"""Adapters of a shaft line: modes, torques, vibration, speeds, limits, transients."""
