"""What a study tells while it runs: on the error stream, so that the report stays clean."""

import sys

from tqdm import tqdm


def announce(study: str, activity: str) -> None:
    """One line, above the progress bar if there is one."""
    tqdm.write(f"{study}: {activity}", file=sys.stderr)
