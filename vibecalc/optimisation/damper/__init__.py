"""The torsional damper of a shaft line, tuned on the whole line over a range of speeds."""
