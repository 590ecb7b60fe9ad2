"""From a validated case to frozen parts made of arrays, and the checks that need physics."""
