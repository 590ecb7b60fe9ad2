"""Plan of the stages of a case, and a run of them."""
