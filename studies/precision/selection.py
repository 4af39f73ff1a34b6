"""Cases without repetition: tuned rows and series may meet."""

from reference_models.trajectory import Case


class Selection:
    """Cases in the order in which they came; of equal labels, the first."""

    def __init__(self) -> None:
        self._cases: dict[str, Case] = {}

    def add(self, *cases: Case) -> None:
        for case in cases:
            self._cases.setdefault(case.label, case)

    @property
    def cases(self) -> list[Case]:
        return list(self._cases.values())
