"""The face of a session: HTTP and JSON on this machine, with server-sent events for those who watch."""
