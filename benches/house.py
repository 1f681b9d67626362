"""Count what makes the sources hard to carry on: names defined twice, lines of code, large traits, long lists of parameters.

Run by hand, ``python benches/house.py [SRC]``. Code is what stands before the first ``#[cfg(test)]`` of a file, without blank
lines and comments. Circles of imports, and those that point upwards, are what ``tests/house/layers.rs`` looks for.
"""

import re
import sys
from collections import defaultdict
from pathlib import Path

SRC = Path(__file__).resolve().parents[1] / "src"
TYPE = re.compile(r"^(?:pub(?:\([a-z ]+\))? )?(?:struct|enum|trait|type|union) (\w+)", re.MULTILINE)
TRAIT = re.compile(r"^(?:pub(?:\([a-z ]+\))? )?trait (\w+).*?^\}", re.MULTILINE | re.DOTALL)
METHOD = re.compile(r"^    (?:const |unsafe )*fn ", re.MULTILINE)
FUNCTION = re.compile(r"\bfn (\w+)(?:<[^()]*>)?\(")
MACRO = re.compile(r"macro_rules! (with_\w+)")
MOST_METHODS = 8
MOST_PARAMETERS = 6


def code_of(path):
    """Return the code of a file."""
    text = re.split(r"#!?\[cfg\(test\)\]", path.read_text())[0]
    lines = (line for line in text.splitlines() if line.strip() and not line.strip().startswith("//"))
    return "\n".join(lines) + "\n"


def parameters(code, start):
    """Return how many parameters, `self` left out, a list has that begins at a place."""
    depth, count, is_word, first = 1, 0, False, ""
    for k in range(start, len(code)):
        letter = code[k]
        if letter == ">" and code[k - 1] == "-":
            continue
        depth += (letter in "([{<") - (letter in ")]}>")
        if depth == 0 or (letter == "," and depth == 1):
            count += is_word and not re.fullmatch(r"&?\s*(?:'\w+ )?(?:mut )?self(?:: .*)?", first.strip())
            is_word, first = False, ""
            if depth == 0:
                return count
        else:
            is_word, first = is_word or not letter.isspace(), first + letter
    raise ValueError("the list has no end")


def told(title, found):
    """Print a count, and what it counts."""
    print(f"{len(found):6}  {title}")
    for line in sorted(found):
        print(f"          {line}")


def main():
    """Count and print."""
    src = Path(sys.argv[1]) if len(sys.argv) > 1 else SRC
    codes = {path.relative_to(src): code_of(path) for path in sorted(src.rglob("*.rs"))}
    places = defaultdict(list)
    for path, code in codes.items():
        for name in TYPE.findall(code):
            places[name].append(str(path))
    lines = {path: code.count("\n") for path, code in codes.items()}
    print(f"{sum(lines.values()):6}  lines of code in {len(lines)} files, {max(lines.values())} in the longest")
    told("type names defined more than once", [f"{name}: {', '.join(at)}" for name, at in places.items() if len(at) > 1])
    traits = [(m[1], len(METHOD.findall(m[0])), path) for path, code in codes.items() for m in TRAIT.finditer(code)]
    told(f"traits of more than {MOST_METHODS} methods", [f"{t}: {n} ({p})" for t, n, p in traits if n > MOST_METHODS])
    functions = [
        (match[1], parameters(code, match.end()), path)
        for path, code in codes.items()
        if path.parts[0] != "python"
        for match in FUNCTION.finditer(code)
    ]
    long = [f"{name}: {n} ({path})" for name, n, path in functions if n > MOST_PARAMETERS]
    told(f"functions of more than {MOST_PARAMETERS} parameters, bindings left out", long)
    told("macros that choose an instance", [f"{name} ({path})" for path, code in codes.items() for name in MACRO.findall(code)])


if __name__ == "__main__":
    main()
