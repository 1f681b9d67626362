"""Shows that a change changes no answer and takes no longer: every number as its bits, and instructions, before and after.

Run by hand, with the interpreter of an environment that has a release build of the package with its extra ``test``:

    python benches/gate record FILE [--only WORD ...]    what the library answers now, in a file (of pickled arrays: your own)
    python benches/gate count FILE [--only WORD ...]     instructions of each case of scene_cost (valgrind)
    python benches/gate compare BEFORE NOW [--roundings] of two records or two counts: what differs; 1 is returned if it may not

Records are compared bit by bit; with ``--roundings`` numbers may differ by ten roundings of their scale times the condition that
the reports state, while counts, statuses and verdicts may not. Counts may rise by 2 % each, and not in their geometric mean.
"""

import argparse
import os
import pickle
import sys
import time
from pathlib import Path

os.environ.setdefault("MPLBACKEND", "Agg")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "examples"))

import counts
from calls import cases
from compare import compare
from recorder import Recorder

SLOW = 5.0  # [s] of a case that is worth a line


def record(path: Path, words: list[str]) -> None:
    """Write what the library answers."""
    recorder, start = Recorder(), time.perf_counter()
    for name, run in cases():
        if words and not any(word in name for word in words):
            continue
        recorder.case, before = name, time.perf_counter()
        with recorder.listening():
            try:
                run()
            except Exception as error:
                recorder.keep("error", error)
                print(f"{name}: {type(error).__name__}: {error}", flush=True)
        if time.perf_counter() - before > SLOW:
            print(f"{name}: {time.perf_counter() - before:.0f} s", flush=True)
    path.write_bytes(pickle.dumps(recorder.kept))
    entries = sum(array.size for array in recorder.kept.values())
    print(f"{len(recorder.kept)} values, {entries} entries, {len(recorder.calls)} cases in {time.perf_counter() - start:.0f} s")


def main() -> int:
    """Record, count or compare."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("job", choices=("record", "count", "compare"))
    parser.add_argument("files", nargs="+", type=Path)
    parser.add_argument("--only", nargs="+", default=[], metavar="WORD", help="cases whose names have one of these")
    parser.add_argument("--roundings", action="store_true", help="numbers may differ by roundings")
    job = parser.parse_args()
    if len(job.files) != (2 if job.job == "compare" else 1):
        parser.error("one file is written, or two are compared")
    if job.job == "compare":
        if counts.is_count(job.files[0]):
            return 0 if counts.compare(*map(counts.read, job.files)) else 1
        before, now = (pickle.loads(path.read_bytes()) for path in job.files)
        return 0 if compare(before, now, job.roundings) else 1
    (counts.write if job.job == "count" else record)(job.files[0], job.only)
    return 0


if __name__ == "__main__":
    sys.exit(main())
