"""Accuracy topics of the roll: speed against error of its methods."""
