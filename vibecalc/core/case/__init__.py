"""A case file to a validated case in SI, or to all its problems in words."""
