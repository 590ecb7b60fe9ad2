"""A machine whose base moves: a ship's deck, a vehicle, a floor next to other machines."""
