"""From a sweep to words and tables: extremes, limits, failures, statistics. No physics here."""
