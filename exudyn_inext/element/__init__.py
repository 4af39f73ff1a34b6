"""The formulas of one element (paper, sections 2.1 to 2.3): one concept a file."""
