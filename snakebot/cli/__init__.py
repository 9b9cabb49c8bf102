"""The command line: one file a subcommand, thin: parse, call, print."""
