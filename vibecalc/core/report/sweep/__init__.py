"""Reports and pictures of sweeps."""
