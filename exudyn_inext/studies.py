"""python -m exudyn_inext.studies: the measured comparisons, as an installed wheel has them or a checkout."""

import importlib
import os
import sys
from pathlib import Path


def main() -> int:
    """What `python -m studies` does in a checkout.   Returns its exit code; 2 if a library is missing."""
    package = Path(__file__).resolve().parent
    folder = str(package / "bundle" if (package / "bundle").is_dir() else package.parent)
    sys.path.insert(0, folder)
    others = os.environ.get("PYTHONPATH")  # which processes that a study starts are told
    os.environ["PYTHONPATH"] = os.pathsep.join([folder, *([others] if others else [])])
    try:
        command = importlib.import_module("studies.__main__")
    except ImportError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    return int(command.main(program="python -m exudyn_inext.studies"))


if __name__ == "__main__":
    sys.exit(main())
