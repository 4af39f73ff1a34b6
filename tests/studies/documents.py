"""Documents as studies store them: made up, small."""

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

from studies.harness.plot import label_axes, new_figure
from studies.harness.store import write_json
from studies.harness.study import Results, measured
from studies.harness.table import TextTable

LONG = 30


def row(label, seconds, error=1e-3, **entries):
    return {
        "label": label, "formulation": "inextensible", "integrator": "RATTLE", "elements": 5,
        "stepSize": 1e-3, "cpuSeconds": seconds, "cpuSecondsMin": 0.99 * seconds, "errorMax": error,
        "status": "ok", **entries,
    }  # fmt: skip


ROWS = [row(f"case {n}", 0.1 * n) for n in range(1, 8)]
SENTENCES = ["The bar of 0.5 is kept (0.31).", "Case 7 | <b>bold</b> is 3.2 times dearer: bar MISSED."]
RATIOS = [
    {"what": "implicit", "paper": 2.42, "here": 47.3},
    {"what": "tuned", "paper": None, "here": 5.6},
    {"what": "failed", "paper": None, "here": None},
]


def document(name="first", rows=ROWS, conclusions=SENTENCES, quick=False, **entries):
    tables = [
        TextTable("Rows:", ("case", "CPU [s]"), [(r["label"], str(r.get("cpuSeconds"))) for r in rows]),
        TextTable("Many:", ("case", "x"), [(f"|r_{n}|", str(n)) for n in range(LONG)]),
    ]
    mode = "quick: 0.5 s of motion" if quick else ""
    concluded = {
        "tables": [vars(table) for table in tables],
        "notes": ["A note."],
        "conclusions": list(conclusions),
        "ratios": RATIOS,
        "pictures": [f"{name}.png"],
    }
    return measured(name, f"What of {name}?", Results(quick, rows, mode)) | concluded | entries


def store(folder, *documents):
    """Documents, and a tiny picture for each."""
    folder.mkdir(parents=True, exist_ok=True)
    for one in documents:
        write_json(folder / f"{one['study']}.json", one)
        (folder / f"{one['study']}.png").write_bytes(tiny_picture())
    return folder


@cache
def tiny_picture():
    """The bytes of its file."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "tiny.png"
        with new_figure(path, 2.0, 1.5) as figure:
            axes = figure.subplots()
            axes.plot([0, 1], [0, 1])
            label_axes(axes, "x [m]", "y [m]")
        return path.read_bytes()
