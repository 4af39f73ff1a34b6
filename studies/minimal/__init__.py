"""What the study `minimal_model` varies: runs inside Exudyn, and dense variants that the package has not."""
