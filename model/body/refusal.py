"""The error of a body model file that can't be used."""


class BodyFileError(ValueError):
    """A body model file that isn't whole, isn't a body or isn't to be trusted.

    The message is one line: what, where, the value, the limit, the remedy.
    """
