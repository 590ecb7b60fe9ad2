"""Weights on the crankshaft and on balance shafts that leave the least force and couple."""
