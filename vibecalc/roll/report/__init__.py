"""Report sections of the roll."""
