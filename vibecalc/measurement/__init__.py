"""The motion of a rigid plate from readings of its vibration."""
