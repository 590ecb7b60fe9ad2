"""Motion of a rigid plate from readings: translation, roll and pitch of each harmonic."""
