"""Plain functions that join methods."""
