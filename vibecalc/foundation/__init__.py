"""A machine on mounts whose ground is not rigid: a floor, a deck or a block on soil."""
