"""How every study is run: timing, errors, storage, tables, plots. One concept a file."""
