"""Parameter and memory tables of both papers."""
