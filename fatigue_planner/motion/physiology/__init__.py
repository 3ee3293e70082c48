"""The physiology of the natural human that the paper leaves out: one file per piece, and the registry of who has it."""
