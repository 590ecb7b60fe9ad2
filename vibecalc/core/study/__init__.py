"""Studies: many runs of a case, to an optimum, to a wanted value, over a grid."""
