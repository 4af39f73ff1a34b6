"""What the documents name exists: modules and functions, files behind links."""

import importlib
import re
from inspect import signature
from pathlib import Path

import exudyn
import pytest
from exudyn.beams import GenerateBeamElementsAlongLine
from exudyn.itemInterface import ObjectANCFCable, ObjectANCFCable2D

import exudyn_inext
from exudyn_inext import CreateInextensibleCable

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
INNER = (
    "element",
    "cable",
    "constraints",
    "loads",
    "integrators",
    "scene",
    "multibody",
    "run",
    "statics",
    "advice",
)
DOCUMENTS = [
    ROOT / "README.md",
    ROOT / "CHANGELOG.md",
    ROOT / "examples" / "README.md",
    *(ROOT / "docs").rglob("*.md"),
]
GENERATED = "generated/"  # by the build of the documentation


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
        r"`((?:element|cable|constraints|scene|loads|integrators|run|statics|items|native|exudyn_binding)\.[\w.]+)`",
        text,
    )
    assert len(names) > 40
    assert [name for name in names if not resolves(name)] == []


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: str(path.relative_to(ROOT)))
def test_no_link_leads_nowhere(document):
    targets = re.findall(r"\]\(([^)#]+)[^)]*\)", document.read_text())
    here = [target for target in targets if "://" not in target and not target.startswith(GENERATED)]
    assert [target for target in here if not (document.parent / target).exists()] == []


def test_a_name_that_does_not_exist_is_noticed():
    assert resolves("cable.factorisation.factorise")
    assert not resolves("cable.factorisation.factorize") and not resolves("cables.links")


def test_the_reference_has_all_that_the_package_offers():
    text = (DOCS / "api" / "user.md").read_text()
    listed = re.findall(r"^\.\. auto(?:function|class|exception):: (\w+)$", text, re.MULTILINE)
    assert sorted(listed) == sorted(exudyn_inext.__all__)


@pytest.mark.parametrize("folder", INNER)
def test_the_reference_has_every_module_of_the_inner_folders(folder):
    text = (DOCS / "api" / f"{folder}.md").read_text()
    listed = set(re.findall(r"^\.\. automodule:: exudyn_inext\.[a-z]+\.(\w+)$", text, re.MULTILINE))
    modules = {path.stem for path in (ROOT / "exudyn_inext" / folder).glob("*.py")}
    assert listed == modules - {"__init__"}


@pytest.mark.parametrize("template", [ObjectANCFCable, ObjectANCFCable2D])
def test_migration_names_every_parameter_of_a_native_cable(template):
    text = (DOCS / "migration.md").read_text()
    names = {name for name in vars(template()) if not name.startswith("physics")} - {"name"}
    assert "axialStiffness" in names
    assert [name for name in names if f"`{name}`" not in text] == []


@pytest.mark.parametrize("generate", [GenerateBeamElementsAlongLine, CreateInextensibleCable])
def test_migration_names_every_argument_of_the_generating_functions(generate):
    text = (DOCS / "migration.md").read_text()
    names = set(signature(generate).parameters) - {"mbs", "dimension", "enforcement"}
    assert [name for name in names if not re.search(rf"\b{name}\b", text)] == []


def test_solver_settings_that_the_migration_page_names_exist():
    """Settings that the migration page speaks of are those of the installed Exudyn."""
    settings = exudyn.SimulationSettings()
    text = (DOCS / "migration.md").read_text()
    for path in re.findall(r"`((?:timeIntegration|linearSolver|solution)(?:\.\w+)*)", text):
        found = settings
        for part in path.split("."):
            assert hasattr(found, part), path
            found = getattr(found, part)
