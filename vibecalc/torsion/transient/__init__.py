"""A shaft line through a change in time: run-up, run-down, load steps."""
