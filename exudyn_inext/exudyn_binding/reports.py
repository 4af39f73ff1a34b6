"""Returned dicts that print as a few lines; `dict(report)` prints all of their values."""

from collections.abc import Iterable
from typing import Any


class Report(dict[str, Any]):
    """A dict that prints as its summary.   _lines: of it, without the keys."""

    def _lines(self) -> Iterable[str]:
        return ()

    def __str__(self) -> str:
        return "\n  ".join([*self._lines(), f"keys: {', '.join(self)}"])

    __repr__ = __str__


class ExplicitReport(Report):
    """What SolveExplicit returns."""

    def _lines(self) -> Iterable[str]:
        bounds, theta = self["bounds"], self["massScaling"]
        scaling = f", massScaling = {theta:g}" if theta else ""
        least, mean = self["stepSize"], self["meanStepSize"]
        h = f"{least:.4g} s" if least > 0.99 * mean else f"{mean:.4g} s on average, {least:.4g} s at least"
        yield (
            f"SolveExplicit: {self['steps']} steps of {self['integrator']}, h = {h} "
            f"(decided by {self['decidedBy']}){scaling}"
        )
        yield f"stability limit: {bounds.stability_limit:.4g} s at the start, from {bounds.cable}"
        yield f"steps rejected and taken again: {self['rejections']}"
        yield f"drift: {', '.join(f'{name} {value + 0.0:.2g}' for name, value in self['drift'].items())}"
        if self["resumedAt"] is not None:
            yield f"continued at t = {self['resumedAt']:.6g} s"
        yield f"path: {self['path']}"


class EnsembleReport(Report):
    """What SolveEnsemble returns."""

    def _lines(self) -> Iterable[str]:
        good, members = self["status"].count("ok"), len(self["status"])
        least, most = min(self["stepSize"]), max(self["stepSize"])
        yield (
            f"SolveEnsemble: {good} of {members} members reached t = {self['times'][-1]:.6g} s, "
            f"{self['integrator']}, h = {least:.4g} to {most:.4g} s, {self['threads']} threads"
        )
        for number, status in enumerate(self["status"]):
            if status != "ok":
                yield f"member {number}: {status}"
        yield f"coordinates: {self['coordinates'].shape} of (members, times, coordinates)"


class StaticReport(Report):
    """What SolveEquilibrium returns."""

    def _lines(self) -> Iterable[str]:
        found = "a stable equilibrium" if self["success"] else "no equilibrium"
        yield (
            f"SolveEquilibrium: {found} after {self['iterations']} iterations, unbalanced force "
            f"{self['residual']:.2g} N, violation of constraints {self['violation']:.2g}"
        )
        lowest = max(self["smallestEigenvalue"], 0.0) ** 0.5
        yield f"lowest natural frequency: {lowest:.4g} rad/s"
        yield f"functions of loads and supports as at timeIntegration.startTime = {self['time']:g} s"
        yield f"cables: {', '.join(row['name'] for row in self['cables'])}"


class EigenvalueReport(Report):
    """What ComputeEigenvalues returns."""

    def _lines(self) -> Iterable[str]:
        yield f"ComputeEigenvalues: {len(self['eigenvalues'])} vibrations, of"
        yield f"{', '.join(f'{one:.5g}' for one in self['frequencies'])} Hz"


class AdviceReport(Report):
    """What Advise returns."""

    def _lines(self) -> Iterable[str]:
        yield f"Advise: {self['reasons'][0]}"
        yield from self["reasons"][1:]
        kind = "expected" if self["extrapolated"] else "measured"
        met = "within" if self["meetsTolerance"] else "above"
        yield (
            f"{kind}: error {self['predictedError']:.2g}, {met} the tolerance; "
            f"{self['predictedSeconds']:.2g} s of CPU time a run"
        )
        yield f"pilots: {len(self['tried'])} runs, {self['pilotSeconds']:.2g} s of CPU time"
        if self["explicitSettings"] is not None:
            yield "next: build(advice['numberOfElements']), SolveExplicit with advice['explicitSettings']"
