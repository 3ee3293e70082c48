"""The formats of recordings: one file per format, each from the bytes of a file to its `Content`."""
