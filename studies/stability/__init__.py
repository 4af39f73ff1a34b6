"""Maps of the study `stability_limits`: one file a map, and what they share."""
