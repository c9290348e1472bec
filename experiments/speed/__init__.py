"""Time and memory, ours and other programs'."""
