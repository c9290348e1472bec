"""How values are written in messages; without JAX, which a photograph is read without."""


def shown(value) -> str:
    """A value in one line of at most 60 characters."""
    text = " ".join(repr(value).split()) if not isinstance(value, int) or abs(value) < 10**60 else "a huge integer"
    return text if len(text) <= 60 else f"{text[:57]}..."
