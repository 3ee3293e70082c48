"""The command `fatplan`: a file per subcommand; results go to stdout, all else to stderr."""
