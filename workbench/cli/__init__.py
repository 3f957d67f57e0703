"""The command line: a file a command."""


def main() -> None:
    """Run the command line. A signal that stops it, while it imports too, is one line."""
    from workbench.cli.progress import AGAIN, say_stopped, stoppable
    from workbench.stopping import stopping_on_signals

    with stopping_on_signals(say_stopped), stoppable(AGAIN):
        from workbench.cli.app import run

        run()
