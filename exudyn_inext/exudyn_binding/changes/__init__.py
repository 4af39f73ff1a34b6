"""What user functions change in a running mbs, and how a run goes on with it."""
