"""Motion of a body on its mounts: modes, forced motion, energies, changes between operations."""
