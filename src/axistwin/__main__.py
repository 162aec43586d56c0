"""`python -m axistwin`: the command line, wherever no script of that name is on the path."""

from axistwin.cli.main import main

if __name__ == "__main__":
    main()
