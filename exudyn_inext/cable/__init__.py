"""A cable as a chain of elements: assembly, structured saddle-point solve, index reduction."""
