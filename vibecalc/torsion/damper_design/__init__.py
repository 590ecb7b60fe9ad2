"""The search for the damper of a shaft line."""
