"""What the documents name exists: modules and functions, files behind links."""

import importlib
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
DOCUMENTS = [
    ROOT / "README.md",
    ROOT / "CHANGELOG.md",
    ROOT / "examples" / "README.md",
    *(ROOT / "docs").glob("*.md"),
]


def resolves(name):
    """Whether a dotted name below the package is a module, or something in one."""
    parts = name.split(".")
    for end in range(len(parts), 0, -1):
        try:
            found = importlib.import_module(".".join(["exudyn_inext", *parts[:end]]))
        except ImportError:
            continue
        for attribute in parts[end:]:
            found = getattr(found, attribute, None)
        return found is not None
    return False


def test_every_function_that_the_method_names_exists():
    text = (ROOT / "docs" / "method.md").read_text()
    names = re.findall(
        r"`((?:element|chain|constraints|coupling|loads|integrators|statics|exudyn_binding)\.[\w.]+)`", text
    )
    assert len(names) > 40
    assert [name for name in names if not resolves(name)] == []


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: str(path.relative_to(ROOT)))
def test_no_link_leads_nowhere(document):
    targets = re.findall(r"\]\(([^)#]+)[^)]*\)", document.read_text())
    missing = [t for t in targets if "://" not in t and not (document.parent / t).exists()]
    assert missing == []


def test_a_name_that_does_not_exist_is_noticed():
    assert resolves("chain.saddle_point.factorise")
    assert not resolves("chain.saddle_point.factorize") and not resolves("chains.border")
