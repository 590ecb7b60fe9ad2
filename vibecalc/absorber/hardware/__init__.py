"""What absorbers are built of: rods, rings, springs, oil gaps, oils."""
