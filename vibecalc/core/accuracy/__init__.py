"""Every method of a stage at a series of settings, as error against work and seconds."""
