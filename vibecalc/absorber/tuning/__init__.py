"""The stiffness and damping that make the response of a primary system smallest."""
