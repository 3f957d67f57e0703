"""The command line: a file a command."""


def main() -> None:
    """Run the command line. A signal that stops it, while it imports too, is one line; one that comes late is none."""
    import signal

    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)  # until there is somebody to hear it: an end without a traceback

    import atexit
    import gc
    import os

    from workbench.cli.progress import AGAIN, say_stopped, stoppable
    from workbench.stopping import ignore, stopping_on_signals

    os.environ.setdefault("ARROW_DEFAULT_MEMORY_POOL", "system")  # what columns took is free again once they are read
    atexit.register(ignore)
    atexit.register(gc.freeze)  # else a million objects are looked through for garbage before the prompt is back
    with stopping_on_signals(say_stopped, to_the_end=True), stoppable(AGAIN):
        from workbench.cli.app import run

        run()
