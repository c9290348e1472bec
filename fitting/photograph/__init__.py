"""The verb `fit`, and stacks: choose, judge, report."""

from newtonjax.doors import door

__getattr__, __dir__ = door(__name__)
