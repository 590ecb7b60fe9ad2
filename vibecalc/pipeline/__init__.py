"""One run: what is planned, why, and the stages in their order."""
