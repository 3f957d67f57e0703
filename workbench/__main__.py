"""`python -m workbench`: the command line where no script of it is on the path."""

from workbench.cli import main

main()
