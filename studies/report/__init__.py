"""The report: everything measured as one Markdown and one HTML page, beside an earlier one."""
