"""Pictures of the roll."""
