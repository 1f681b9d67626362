"""Every case by its name: the programs that count and that measure memory are told names."""

from __future__ import annotations

import functools

from report.cost.case import Case
from report.cost.catalogue import groups
from report.cost.growth import series


@functools.cache
def cases() -> dict[str, Case]:
    """Every case: the features of a scene, the sizes of the series."""
    features = {name: case for group in groups() for name, case in zip(group.names(), group.cases, strict=True)}
    sizes = {f"{each.key} {size}": each.case(size) for each in series() for size in each.sizes}
    return {**features, **sizes}


def find(name: str) -> Case:
    """The case of a name."""
    return cases()[name]
