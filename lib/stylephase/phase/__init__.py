"""Phases: the local motion phases of [M22] 4.1 and the global phase of [M18] 5."""
