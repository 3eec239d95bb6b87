"""What a run needs, as a file that a person can write and read: pydantic models only."""
