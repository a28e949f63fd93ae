# SPDX-License-Identifier: GPL-3.0-or-later
"""What of a scene could not be handed over as it is."""


class Report:
    """Lines for the user, each once, in the order of their first mention."""

    def __init__(self):
        self.lines = []

    def note(self, line):
        if line not in self.lines:
            self.lines.append(line)

    def __bool__(self):
        return bool(self.lines)


class CannotRender(Exception):
    """One line for the user: what, where, what to do."""
