"""From a TOML file to a validated case in SI units and radians."""
