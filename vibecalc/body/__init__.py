"""The body of a machine that is assembled of parts: its mass, centre and moments of inertia."""
