"""Plain methods that topics hold the project's own against: integrators, grids, samples."""
