"""From readings of a case to the motion of the plate and to results."""
