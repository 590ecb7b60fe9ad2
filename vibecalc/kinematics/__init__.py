"""Motion of the slider-crank, exact and as harmonics."""
