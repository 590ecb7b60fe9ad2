"""One case, many runs."""
