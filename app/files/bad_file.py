"""What goes wrong with a file of results."""


class ResultFileError(ValueError):
    """A result file is missing, of another kind, or damaged; the message says which and what to do."""
