"""The reduced model of roll, the feedback that calms it, and how far that is from diverging."""
