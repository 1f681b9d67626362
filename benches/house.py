"""Count what makes the sources hard to carry on: names defined twice, lines of code, large traits, long lists of parameters.

Run by hand, ``python benches/house.py [SRC]``. Code is what stands before the first ``#[cfg(test)]`` of a file, without blank
lines and comments. Circles of imports, and those that point upwards, are what ``tests/house/layers.rs`` looks for.

Files that name a state of a contact element
    Files outside ``law/`` and ``hybrid/`` whose code has the word ``held`` (alone, or as a part of a name in snake case) or
    ``ContactMode``, a variant of ``ElementState``, ``GuardKind``, ``Transition`` or ``SegmentKind``, or a question that
    is about one of them (``holds``, ``constrained``, ``is_release`` ...): a state of a contact, a kind of guard, of transition or of
    what follows it. A new law of contact has to be looked for in each. Each stands with its words. Not about any of them are ``is_free``
    and ``leaves_free``, as all laws have that state, and ``Arrival``, which has the guard that fell through zero and not its kind.
Loops that bracket or halve outside the root finder
    Functions, in other files than those of the root finder (``root/``), that have a ``for``, ``while`` or ``loop``, and from there
    on one of: the middle of two numbers, ``0.5 * (a + b)`` or ``midpoint``; the formula of a secant, ``y * (b - a) / (..)``; a
    constant whose name has BISECT, GOLDEN, ILLINOIS or HALVING; a name that begins with golden, illinois or newton. Each searches
    for a place, or parts an interval, by a loop of its own. The rule reads names and formulas, not meanings: a search in other
    words is not found, and a middle taken for another purpose is.
Loops that try again with half a length
    The same with ``x *= 0.5`` or ``x = 0.5 * x``: a step that did not succeed, which no bracket is needed for.
Places of the law of one impact
    Lines outside ``law/`` and the bindings with one plus a coefficient of restitution, ``1.0 + e``, ``-1.0 - e``,
    ``1.0 + ..restitution..`` or ``restitution.add_scalar(1.0)``: the factor of the impulse ``(1 + e) (n.v) / (n.b)`` of an
    impact, and of its derivatives.
Test binaries
    Files ``tests/*.rs`` and ``tests/*/main.rs`` beside the sources: each is linked with the crate by itself.
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
INDENTED_FUNCTION = re.compile(r"^( *)(?:pub(?:\([a-z ]+\))? )?(?:const |unsafe )*fn (\w+).*?^\1\}", re.MULTILINE | re.DOTALL)
CONTACT_STATE = re.compile(
    r"(?<![a-zA-Z])held(?![a-z])|\bContactMode\b|\b(?:SegmentKind|ElementState|GuardKind|Transition)::(?=[A-Z])|\bGuard::(?:gap|force)\b"
    r"|\.(?:holds|holding|holding_instead|constrained|is_strike|is_release|is_chatter|is_stick|struck|is_rigid)\("
)
LAWS = ("law", "hybrid")
LOOP = re.compile(r"\b(?:for|while|loop)\b[^;]*\{")
MIDDLE = r"0\.5 \* \([\w.\[\]]+ \+ [\w.\[\]]+\)|\bmidpoint\b"
SECANT = r"\* \([\w.\[\]]+ - [\w.\[\]]+\) / \("
SEARCH = re.compile(r"\w*(?:HALVING|BISECT|GOLDEN|ILLINOIS)\w*|\b(?:golden|illinois|newton)\w*")
FORMULA = re.compile(f"{MIDDLE}|{SECANT}")
AGAIN = re.compile(r"\*= 0\.5|\b(\w+) = 0\.5 \* \1\b")
ROOT_FINDER = "root"
COEFFICIENT = r"(?:[\w.\[\]]+\.)?(?:e\b|restitution)"
IMPACT_LAW = re.compile(rf"\b1\.0 \+ {COEFFICIENT}|-1\.0 - {COEFFICIENT}|restitution\.add_scalar\(1\.0\)")
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


def contact_states(codes):
    """Return the files in which a state of a contact element, a guard or a transition is named, with the words."""
    found = {path: sorted(set(CONTACT_STATE.findall(code))) for path, code in codes.items() if path.parts[0] not in LAWS}
    return [f"{path}: {', '.join(words)}" for path, words in found.items() if words]


def searches(codes):
    """Return the functions that bracket in a loop outside the root finder, and those that try again with half a length, by file."""
    bracket, again = defaultdict(list), defaultdict(list)
    for path, code in codes.items():
        functions = () if path.parts[0] == ROOT_FINDER else INDENTED_FUNCTION.finditer(code)
        for match in functions:
            loop = LOOP.search(match[0])
            if not loop:
                continue
            if FORMULA.search(match[0], loop.start()):
                bracket[path].append(match[2])
            elif AGAIN.search(match[0], loop.start()):
                again[path].append(match[2])
            elif SEARCH.search(match[0], loop.start()):
                bracket[path].append(match[2])
    return bracket, again


def impact_laws(codes):
    """Return the lines in which the law of one impact is written."""
    own = ((path, code) for path, code in codes.items() if path.parts[0] not in ("law", "python"))
    return [f"{path}: {line.strip()}" for path, code in own for line in code.splitlines() if IMPACT_LAW.search(line)]


def test_binaries(tests):
    """Return the files that are test binaries."""
    return [str(path.relative_to(tests.parent)) for pattern in ("*.rs", "*/main.rs") for path in tests.glob(pattern)]


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
    told("files outside law/ and hybrid/ that name a state of a contact element, a guard or a transition", contact_states(codes))
    titles = ("loops that bracket or halve outside the root finder", "loops that try again with half a length")
    for title, found in zip(titles, searches(codes), strict=True):
        count = sum(map(len, found.values()))
        told(f"files of {count} {title}", [f"{path}: {', '.join(names)}" for path, names in found.items()])
    told("places of the law of one impact", impact_laws(codes))
    told("test binaries", test_binaries(src.parent / "tests"))


if __name__ == "__main__":
    main()
