"""Impacts in joints with play: contacts, their forces, their statistics."""
