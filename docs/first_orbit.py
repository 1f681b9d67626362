"""Make the pictures at the top of the README: the one of its first lines by running them, the one that moves by the example of the wall pendulum."""

import os
import re
import runpy
import shutil
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).parent
ROOT = HERE.parent


def main() -> None:
    """Run both where nothing else is, and keep their pictures."""
    first = re.search(r"```python\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.DOTALL)
    assert first is not None, "the README has a block of Python"
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        exec(compile(first.group(1), "README.md", "exec"), {})
        shutil.copy("orbit.png", HERE / "figures" / "first_orbit.png")
        sys.argv = ["wall_pendulum.py", "--output", folder]
        runpy.run_path(str(ROOT / "examples" / "wall_pendulum.py"), run_name="__main__")
        shutil.copy("wall_pendulum.gif", HERE / "figures" / "wall_pendulum.gif")
        os.chdir(ROOT)


if __name__ == "__main__":
    main()
