#!/usr/bin/env -S uv run --script
# /// script
# dependencies = ["nox"]
# ///
"""Sessions of nox: the steps of ``.ci/run``, which makes the environment that it needs by itself."""

import nox

nox.needs_version = ">=2025.2.9"
nox.options.default_venv_backend = "none"

for step in ("lint", "rust", "python", "package", "site", "examples", "wheel"):
    nox.session(
        lambda session, step=step: session.run("bash", ".ci/run", step, external=True),
        name=step,
        default=step in {"lint", "rust", "python"},
    )

if __name__ == "__main__":
    nox.main()
