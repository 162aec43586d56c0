"""`python -m axistwin`: the command line without an installed script."""

from axistwin.cli import main

if __name__ == "__main__":
    main()
