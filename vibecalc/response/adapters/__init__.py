"""Stages of the response: from a case to recorded results."""
