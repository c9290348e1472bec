"""The part of a film between pressed faces."""

from fitting.model.part import AbstractPart


class Film(AbstractPart):
    """A film that keeps pressed faces apart, so that the phase of their disc is not that of no gap."""

    name = "film"
    needs = ("contact",)
    lifts = ("phase",)
    # That of the phase.
    price = 1
