"""The only place that imports exudyn: items in, time loop, results out."""
