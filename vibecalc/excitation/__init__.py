"""What drives a machine: inertia of its crank train, gas in its cylinders, its motor."""
