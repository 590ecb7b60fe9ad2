"""The body on its mounts: rigid-body and pitch models, run-up, torque reaction."""
