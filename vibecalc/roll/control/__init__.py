"""Control of the motor of a roll machine by a linear loop, and the full machine under it."""
