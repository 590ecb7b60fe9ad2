"""A rotor, pistons and the shell they share, turning about the crank axis under a real motor."""
