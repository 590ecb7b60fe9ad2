"""Search: the best values of some variables within bounds, with limits kept."""
