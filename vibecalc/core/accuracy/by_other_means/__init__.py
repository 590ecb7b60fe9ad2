"""Plain methods that those of the package are held against."""
