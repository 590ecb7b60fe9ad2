"""Absorbers on a vibrating primary system and pendulums on a rotor: response, tuning, hardware."""
