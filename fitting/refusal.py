"""Why a study of a bench ends without an answer."""


class UndeterminedError(ValueError):
    """The image does not tell what is asked for; the shell exits with 3."""
