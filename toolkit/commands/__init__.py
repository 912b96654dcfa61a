"""The subcommands: each module says whether all ranks work on it, and what it does."""
