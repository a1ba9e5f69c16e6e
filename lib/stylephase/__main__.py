"""`python -m stylephase` is the command `stylephase`."""

from stylephase.cli.app import main

if __name__ == "__main__":
    main()
