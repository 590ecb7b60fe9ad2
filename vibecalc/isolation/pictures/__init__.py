"""Pictures of the body on its mounts."""
