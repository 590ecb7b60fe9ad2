"""Pendulums that swing in the centrifugal field of a turning rotor and follow an order of it."""
