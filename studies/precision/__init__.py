"""Parts of `work_precision`: what is run on each scene, and what is read off the fronts."""
