"""External loads of a cable as generalised forces, Eq. (17): one kind a file."""
