"""Searches for the minimum of a function of bounded variables under limits."""
