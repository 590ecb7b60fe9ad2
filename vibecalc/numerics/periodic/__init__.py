"""Periodic solutions of ordinary differential equations."""
