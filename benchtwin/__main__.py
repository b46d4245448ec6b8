"""`python -m benchtwin`: the command line."""

from benchtwin.command_line import main

if __name__ == "__main__":
    main()
