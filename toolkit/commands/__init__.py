"""The subcommands: each module says its arguments, whether all ranks work on it, and what it does."""
