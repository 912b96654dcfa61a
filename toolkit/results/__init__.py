"""What a run leaves: records, files, folders and their description in words."""
