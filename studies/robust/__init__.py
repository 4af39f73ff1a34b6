"""Random scenes for the study of robustness."""
