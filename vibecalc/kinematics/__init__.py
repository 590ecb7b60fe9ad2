"""Motion of the slider-crank: pistons and connecting rods."""
