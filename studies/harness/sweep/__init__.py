"""Sweeps: one function over many cases, on any `concurrent.futures.Executor`, resumable."""
