"""Many photographs: jobs for worker processes, a file of rows that survives kills, a summary and a control chart."""

from newtonjax.doors import door

__getattr__, __dir__ = door(__name__)
