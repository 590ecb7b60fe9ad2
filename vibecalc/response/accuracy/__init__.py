"""Accuracy topics of the response: speed against error of its methods."""
