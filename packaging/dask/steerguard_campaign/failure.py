"""What the command says when it cannot do what was asked."""


class Failure(Exception):
    """What is wrong, and what to do about it."""

    def __init__(self, what, help=None, exit_code=2):
        super().__init__(what)
        self.help = help
        self.exit_code = exit_code

    def text(self):
        return f"error: {self}" + (f"\nhelp: {self.help}" if self.help else "")


class Refusal(Failure):
    """The `steerguard` command has said what is wrong."""

    def __init__(self, text, exit_code):
        super().__init__(text, exit_code=exit_code)

    def text(self):
        return str(self)
