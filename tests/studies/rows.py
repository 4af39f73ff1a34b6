"""Rows as a study stores them: made up, and read back."""

import json


def row(label, formulation, integrator, cpu, error, quadrature="full"):
    return {
        "label": label,
        "formulation": formulation,
        "integrator": integrator,
        "cpuSeconds": cpu,
        "errorMax": error,
        "quadrature": quadrature,
    }


def rows_of(directory, name):
    document = json.loads((directory / f"{name}.json").read_text())
    return {row["label"]: row for row in document["rows"]}, document
