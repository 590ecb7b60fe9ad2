"""Speed against error: every method of a stage over a ladder of its settings, against the truth."""
