"""What shaft lines and absorbers share of their centrifugal pendulums."""

#: rad, of a swing for which equations for small ones will do
SMALL_SWING = 0.2
