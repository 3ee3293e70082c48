"""The kinds of tasks that make up a motion preference, a file each."""
