"""Attractors as a store keeps them: without their scene, which may be made of functions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from typing import Any

from vibroimpact import _core
from vibroimpact._core import Scene
from vibroimpact.results import encoding
from vibroimpact.results.attractors import Attractor, Attractors


def without_scene(attractors: Sequence[Attractor]) -> dict[str, Any]:
    """Return attractors as arrays, numbers and texts."""
    each = []
    for one in attractors:
        parts = {own.name: getattr(one, own.name) for own in fields(one)}
        orbit = None if one.orbit is None else list(encoding.pieces(one.orbit)[0][1:])
        each.append(parts | {"orbit": orbit})
    search = None
    if isinstance(attractors, Attractors):
        search = [attractors.seeds, attractors.of_seed, attractors.box, attractors.phase, attractors.wrap]
    return {"attractors": each, "search": search}


def with_scene(kept: dict[str, Any], scene: Scene) -> Attractors | tuple[Attractor, ...]:
    """Return the attractors of a scene again."""
    each = []
    for parts in kept["attractors"]:
        orbit = None if parts["orbit"] is None else _core._restore_orbit(scene, *parts["orbit"])
        each.append(Attractor(**(parts | {"orbit": orbit})))
    return tuple(each) if kept["search"] is None else Attractors(scene, tuple(each), *kept["search"])
