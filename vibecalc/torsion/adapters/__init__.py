"""From a case with a shaft line to results."""
