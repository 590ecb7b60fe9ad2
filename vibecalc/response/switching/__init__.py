"""What a body on mounts does while its crank train changes: switched loads, stops, reversals."""
