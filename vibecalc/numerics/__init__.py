"""Numerical methods that two stages share."""
