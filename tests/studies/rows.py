"""Rows as a study stores them, made up."""


def row(label, formulation, integrator, cpu, error, quadrature="full"):
    return {
        "label": label,
        "formulation": formulation,
        "integrator": integrator,
        "cpuSeconds": cpu,
        "errorMax": error,
        "quadrature": quadrature,
    }
