"""Tables of the README and of the docs, and the report: written from committed results, never typed."""
