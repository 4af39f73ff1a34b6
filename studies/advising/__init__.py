"""Parts of the study `adviser`."""
