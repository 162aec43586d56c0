"""`python -m axistwin`: the command line without an installed script."""

from axistwin.cli.program import main

if __name__ == "__main__":
    main()
