"""Parts of the study `advice`."""
