"""How values are written in messages, and sentences that programs can tell apart; without JAX."""

from collections.abc import Callable, Iterable, Mapping
from enum import Enum
from types import MappingProxyType
from typing import Any


def shown(value) -> str:
    """A value in one line of at most 60 characters."""
    text = " ".join(repr(value).split()) if not isinstance(value, int) or abs(value) < 10**60 else "a huge integer"
    return text if len(text) <= 60 else f"{text[:57]}..."


class Statement(str):
    """A sentence with the name and the template that it was made of, and the values in it by name.

    `template` and `values` are empty where only the text was saved.
    """

    code: str
    template: str
    values: Mapping[str, Any]

    def __new__(
        cls, text: str, code: str, template: str = "", values: Mapping[str, Any] = MappingProxyType({})
    ) -> "Statement":
        """A sentence; `Wording` members make them with their values."""
        statement = super().__new__(cls, text)
        statement.code, statement.template, statement.values = code, template, dict(values)
        return statement

    def __reduce__(self) -> tuple:
        return type(self), (str(self), self.code, self.template, self.values)

    def translated(self, translate: Callable[[str], str]) -> str:
        """The sentence in another language: `translate`, such as gettext, maps templates to templates."""
        if not self.template:
            return str(self)
        values = {
            name: value.translated(translate) if isinstance(value, Statement | Joined) else value
            for name, value in self.values.items()
        }
        return translate(self.template).format(**values)


class Joined(str):
    """Texts with a separator between them, as a value of a sentence."""

    separator: str
    parts: tuple[str, ...]

    def __new__(cls, separator: str, parts: Iterable[str]) -> "Joined":
        """The texts in their order."""
        parts = tuple(parts)
        joined = super().__new__(cls, separator.join(parts))
        joined.separator, joined.parts = separator, parts
        return joined

    def __reduce__(self) -> tuple:
        return type(self), (self.separator, self.parts)

    def translated(self, translate: Callable[[str], str]) -> str:
        """The texts, those that are sentences in another language."""
        return self.separator.join(
            part.translated(translate) if isinstance(part, Statement | Joined) else part for part in self.parts
        )


class Wording(Enum):
    """Members whose value is a template in the syntax of `str.format`; called with its values one gives a sentence."""

    def __call__(self, **values: Any) -> Statement:
        """The sentence. Raises KeyError for a value that the template needs and that is not there."""
        return Statement(self.value.format(**values), self.name, self.value, values)
