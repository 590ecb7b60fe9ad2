"""A shaft line whose inertias change over the revolution."""
