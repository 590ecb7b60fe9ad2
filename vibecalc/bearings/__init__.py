"""Loads on the bearings of a crank train: crank pins, wrist pins, cylinder walls, main bearings."""
