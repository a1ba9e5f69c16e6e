"""Skeletons, clips, BVH files, the character's root frame, contacts, mirroring, and the synthetic walker."""
