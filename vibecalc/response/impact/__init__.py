"""Impacts in joints with play: event-exact motion and fixed-step methods, for batches of runs."""
