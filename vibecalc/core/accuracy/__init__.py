"""Every method of a stage at a refinement of settings, as error against work and seconds."""
