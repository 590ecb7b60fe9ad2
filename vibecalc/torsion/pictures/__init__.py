"""Pictures of shaft lines."""
