"""Every method of a stage at a ladder of settings, as error against work and seconds."""
