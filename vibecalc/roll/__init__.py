"""Roll of a machine whose motor finds the speed: running state, start-up, control of the motor."""
