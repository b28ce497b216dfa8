"""`python -m openbench` is the command `openbench`."""

from openbench._command import main

main()
