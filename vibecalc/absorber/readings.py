"""Names of what is read of a primary and its absorber, and what of it a ground leaves unbounded."""

#: what only an absorber has
OF_ABSORBER = ("travel", "spring_force", "damper_force")
#: what grows without bound under a constant acceleration of the ground
DRIFTING = ("displacement", "velocity")


def drifts(excitation: str, response: str) -> bool:
    """Whether a reading has no bound at rest: what a constant acceleration of the ground moves."""
    return excitation == "base_acceleration" and response in DRIFTING
