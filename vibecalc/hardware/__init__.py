"""What a tuning is built of: rods, springs, seismic masses, gaps, oils, and how the rod bends."""
