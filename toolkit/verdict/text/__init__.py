"""The verdict in words: the sentence, its table, what it hangs on, and what was not answered."""
