"""Closed-form stages for many points of a case at once: one array call instead of one run each."""
