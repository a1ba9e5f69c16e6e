"""The command `stylephase`: one module for each subcommand, found by its file name (see app.py)."""
