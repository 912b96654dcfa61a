"""The results of a run: records, files, folders and comparisons."""
