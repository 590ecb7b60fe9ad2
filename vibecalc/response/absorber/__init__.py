"""A primary system with a tuned absorber: response, exact peaks, poles and fixed points."""
