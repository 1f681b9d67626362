"""What tells callables apart: any edit that changes what a call returns is seen, equal code is equal in another process."""

import json
import os
import random
import subprocess
import sys
from types import ModuleType

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vibroimpact.run.fingerprint import fingerprint, parts

#: Modules with a callable ``f`` of one number, each after what is edited in it, where ?? stands.
EDITED = r"""
### its own code
def f(x): return x + ??

### a default
def f(x, a=??): return x + a

### a default by name
def f(x, *, a=??): return x + a

### a value enclosed
def make(a):
    def f(x): return x + a
    return f
f = make(??)

### a list enclosed
def make(a):
    def f(x): return x + a[0]
    return f
f = make([??])

### a function enclosed
def make(g):
    def f(x): return g(x)
    return f
f = make(lambda x: x + ??)

### a lambda within
def f(x): return (lambda y: y + ??)(x)

### a comprehension
A = [??]
def f(x): return sum([x + a for a in A])

### a global number
A = ??
def f(x): return x + A

### a global read within a function within
A = ??
def f(x):
    def g(): return x + A
    return g()

### a global in a dictionary
A = {'a': [0, {'b': ??}]}
def f(x): return x + A['a'][1]['b']

### a global array
import numpy as np
A = np.array([1.0, ??])
def f(x): return x + A[1]

### a global array of objects
import numpy as np
A = np.array([None, ??], dtype=object)
def f(x): return x + A[1]

### a global set
A = {3, ??}
def f(x): return x + sum(A)

### a helper
def g(x): return x + ??
def f(x): return g(x)

### a helper's default
def g(x, a=??): return x + a
def f(x): return g(x)

### a helper's helper's global
A = ??
def h(): return A
def g(x): return x + h()
def f(x): return g(x)

### helpers that call each other
def g(n, x): return x if n == 0 else h(n, x)
def h(n, x): return g(n - 1, x + ??)
def f(x): return g(3, x)

### an attribute of the function
def f(x): return x + f.a
f.a = ??

### an attribute of a helper
def g(): pass
g.a = ??
def f(x): return x + g.a

### the code of a class
class C:
    def __call__(self, x): return x + ??
f = C()

### the code of a base
class B:
    def g(self, x): return x + ??
class C(B):
    def __call__(self, x): return self.g(x)
f = C()

### an attribute of a class
class C:
    a = ??
    def __call__(self, x): return x + self.a
f = C()

### an attribute of a class that is read
class C:
    a = ??
def f(x): return x + C.a

### a property
class C:
    @property
    def a(self): return ??
    def __call__(self, x): return x + self.a
f = C()

### a static method
class C:
    @staticmethod
    def a(): return ??
    def __call__(self, x): return x + self.a()
f = C()

### a class method
class C:
    @classmethod
    def a(cls): return ??
    def __call__(self, x): return x + self.a()
f = C()

### a cached property
import functools
class C:
    @functools.cached_property
    def a(self): return ??
    def __call__(self, x): return x + self.a
f = C()

### the class of a class
class M(type):
    def a(cls): return ??
class C(metaclass=M):
    def __call__(self, x): return x + type(self).a()
f = C()

### the state of an object
class C:
    def __init__(self, a): self.a = a
    def __call__(self, x): return x + self.a
f = C(??)

### the state of an object with slots
class C:
    __slots__ = ('a',)
    def __init__(self, a): self.a = a
    def __call__(self, x): return x + self.a
f = C(??)

### an object in an object
class D:
    def __init__(self, a): self.a, self.own = a, self
class C:
    def __init__(self, a): self.d = [D(a)]
    def __call__(self, x): return x + self.d[0].own.a
f = C(??)

### a method of an object
class C:
    def __init__(self, a): self.a = a
    def g(self, x): return x + self.a
f = C(??).g

### a global object
class C: pass
c = C()
c.a = ??
def f(x): return x + c.a

### a list that can be called
class C(list):
    def __call__(self, x): return x + self[0] + self.a
f = C([1])
f.a = ??

### items of a list that can be called
class C(list):
    def __call__(self, x): return x + self[0]
f = C([??])

### the code of a list that can be called
class C(list):
    def __call__(self, x): return x + ??
f = C([1])

### a class that makes
class C(float):
    def __new__(cls, x): return float.__new__(cls, x + ??)
f = C

### a data class
from dataclasses import dataclass, field
@dataclass
class C:
    a: list = field(default_factory=lambda: [??])
    b: float = 1.0
def f(x): return x + C().a[0]

### a default of a data class
from dataclasses import dataclass
@dataclass(frozen=True)
class C:
    a: float = ??
def f(x): return x + C().a

### a named tuple
from typing import NamedTuple
class C(NamedTuple):
    a: float = ??
c = C()
def f(x): return x + c.a

### an enumeration
from enum import Enum
class C(Enum):
    A = ??
def f(x): return x + C.A.value

### a partial
from functools import partial
def g(a, x): return x + a
f = partial(g, ??)

### a keyword of a partial
from functools import partial
def g(x, a): return x + a
f = partial(g, a=??)

### the function of a partial
from functools import partial
def g(x): return x + ??
f = partial(g)

### a partial of an object
from functools import partial
class C:
    def __call__(self, x): return x + ??
f = partial(partial(C()))

### a cached function
import functools
@functools.lru_cache(None)
def f(x): return x + ??

### a cached helper
import functools
@functools.cache
def g(x): return x + ??
def f(x): return g(x)

### a global of a cached helper
import functools
A = ??
@functools.cache
def g(x): return x + A
def f(x): return g(x)

### a wrapped function
import functools
def twice(g):
    @functools.wraps(g)
    def both(x): return g(x) + g(x)
    return both
@twice
def f(x): return x + ??

### what wraps a function
import functools
def more(g):
    @functools.wraps(g)
    def both(x): return g(x) + ??
    return both
@more
def f(x): return x

### what wraps a function of a library
import functools, math
def more(g):
    @functools.wraps(g)
    def both(x): return g(x) + ??
    return both
f = more(math.sin)

### a vectorised function
import numpy as np
f = np.vectorize(lambda x: x + ??)

### a generator
def g(x):
    yield x + ??
def f(x): return sum(g(x))

### where a try ends
def g(x): raise KeyError
def f(x):
    try: return g(x)
    except KeyError: return x + ??

### a global read by name
A = ??
def f(x): return x + globals()['A']

### a global in a text
A = ??
def f(x): return eval('x + A')

### random numbers
import numpy as np
r = np.random.default_rng(int(??))
def f(x): return x + np.random.Generator(type(r.bit_generator)(int(??))).random()

### a polynomial of a library
import numpy as np
f = np.polynomial.Polynomial([1.0, ??])

### a spline of a library
from scipy.interpolate import CubicSpline
f = CubicSpline([0, 1, 2, 3], [0, 1, ??, 2])

### a function put into a library's module
import numpy as np
np.put_here = lambda x: x + ??
def f(x): return np.put_here(x)
"""
EDITED = dict(one.split("\n", 1) for one in EDITED.strip().removeprefix("### ").split("\n### "))


def made(text, name="edited_here"):
    """The callable of a module of the user's own, made of a text."""
    module = ModuleType(name)
    sys.modules[name] = module
    exec(compile(text, f"/somewhere/{name}.py", "exec"), vars(module))
    return module.f


@pytest.mark.parametrize("what", EDITED)
def test_an_edit_that_changes_a_result_is_seen(what):
    values, told = [], []
    for number in ("2.0", "3.0", "2.0"):
        f = made(EDITED[what].replace("??", number))
        told.append(parts(f))
        values.append(float(f(0.7)))
    assert values[0] == values[2] != values[1]
    assert told[0] == told[2] != told[1]
    assert set(told[1]) == set(told[0])


TOLD = """
import json, sys
sys.path.insert(0, sys.argv[1])
from test_fingerprint import made
from vibroimpact.run.fingerprint import parts
print(json.dumps([parts(made(text)) for text in json.load(sys.stdin)]))
"""


def told_elsewhere(texts, seed):
    """Parts of callables as another process has them, with another seed of hashes."""
    call = [sys.executable, "-c", TOLD, os.path.dirname(__file__)]
    env = os.environ | {"PYTHONHASHSEED": str(seed)}
    return json.loads(subprocess.run(call, input=json.dumps(texts), env=env, capture_output=True, text=True, check=True).stdout)


def test_equal_code_is_equal_in_another_process():
    texts = [text.replace("??", "2.0") for text in EDITED.values()]
    texts.append("A = frozenset('abcdefgh')\nB = {'k', 'l', 'm'}\ndef f(x): return x in {'a', 'b', 'c', 'd'} or x in A or x in B")
    here = [parts(made(text)) for text in texts]
    for seed in (1, 2):
        assert told_elsewhere(texts, seed) == here


class Program:
    """Random modules: helpers of every kind that read constants and call each other."""

    def __init__(self, seed):
        self.random = random.Random(seed)
        self.lines = ["import functools", "from functools import partial"]
        self.calls = ["abs({})"]
        self.numbers = []
        for k in range(self.random.randint(3, 8)):
            self.calls.append(self.random.choice((self.plain, self.method, self.state, self.closed, self.part, self.cached))(k))
        self.lines.append(f"def f(x): return {self.of('x')} + {self.calls[-1].format('x')}")

    def number(self):
        """A place for a number, written in the line where it stands or as a global."""
        place = f"??{len(self.numbers)}??"
        self.numbers.append(self.random.choice((0.5, 1.5, 2.0, 3)))
        if self.random.random() < 0.4:
            self.lines.append(f"G{len(self.numbers)} = {self.random.choice(('[{}][0]', '{}', 'dict(a={})')).format(place)}")
            return f"G{len(self.numbers)}" + ("['a']" if "dict" in self.lines[-1] else "")
        return place

    def of(self, x):
        return f"({x} {self.random.choice('+-*')} {self.number()} + {self.random.choice(self.calls).format(x)})"

    def plain(self, k):
        default = f", a={self.number()}" if self.random.random() < 0.5 else ""
        self.lines.append(f"def p{k}(x{default}): return {self.of('x')}" + (" + a" if default else ""))
        return f"p{k}({{}})"

    def method(self, k):
        base = self.of("x")
        self.lines += [f"class B{k}:", f"    def g(self, x): return {base}", f"class C{k}(B{k}):", f"    a = {self.number()}"]
        self.lines.append("    def __call__(self, x): return self.g(x) + self.a")
        return f"C{k}()({{}})"

    def state(self, k):
        number, own = self.number(), self.of("x")
        self.lines += [f"class S{k}:", "    def __init__(self, a): self.a = {'k': [a]}", "    def __call__(self, x):"]
        self.lines += [f"        return {own} + self.a['k'][0]", f"s{k} = S{k}({number})"]
        return f"s{k}({{}})"

    def closed(self, k):
        own, number = self.of("x"), self.number()
        self.lines += [f"def m{k}(a):", f"    def inner(x): return {own} * a", "    return inner", f"c{k} = m{k}({number})"]
        return f"c{k}({{}})"

    def part(self, k):
        own, number = self.of("x"), self.number()
        self.lines += [f"def q{k}(a, x): return {own} - a", f"r{k} = partial(q{k}, {number})"]
        return f"r{k}({{}})"

    def cached(self, k):
        own = self.of("x")
        self.lines += ["@functools.lru_cache(8)", f"def l{k}(x): return {own}"]
        return f"l{k}({{}})"

    def text(self, edit=None):
        lines = "\n".join(self.lines)
        for k, number in enumerate(self.numbers):
            lines = lines.replace(f"??{k}??", repr(number if k != edit else number + 1))
        return lines


def results(f):
    return [f(x) for x in (0.3, -1.7, 2.9)]


@given(st.integers(0, 2**32), st.data())
@settings(deadline=None, max_examples=int(os.environ.get("VIBROIMPACT_CASES", "60")))
def test_random_edits_are_seen(seed, data):
    program = Program(seed)
    edit = data.draw(st.integers(0, len(program.numbers) - 1))
    f, again, edited = (made(program.text(k)) for k in (None, None, edit))
    before = parts(f)
    changes = results(f) != results(edited)
    # Calls do not change what is told of them.
    assert parts(f) == parts(again) == before
    if changes:
        assert parts(edited) != before


def test_random_code_is_equal_in_another_process():
    texts = [Program(seed).text() for seed in range(40)]
    assert told_elsewhere(texts, 3) == [parts(made(text)) for text in texts]


def test_numbers_that_are_equal_are_not_the_same():
    texts = ["0.0", "-0.0", "0", "False", "0j", "-0j", "(0,)", "[0]", "{0}", "frozenset((0,))", "'0'", "b'0'", "None", "{0: 0}"]
    assert len({fingerprint(made(f"A = {text}\ndef f(x): return A")) for text in texts}) == len(texts)
    assert len({fingerprint(made(f"def f(x, a={text}): return a")) for text in texts}) == len(texts)


def test_what_does_not_matter_is_not_told():
    plain = fingerprint(made("def f(x): return x + 1"))
    assert fingerprint(made("# a line\nB = 3\n\ndef f(x):\n    # another\n    return x + 1\ndef g(): return B")) == plain
    cached = made("import functools\n@functools.lru_cache(None)\ndef f(x): return x + 1")
    before = fingerprint(cached)
    cached(3)
    assert fingerprint(cached) == before


def test_files_of_the_user_are_looked_through(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(tmp_path)
    package = tmp_path / "own_package"
    package.mkdir()
    (package / "__init__.py").write_text("")
    uses = {
        "import own_package.model\ndef f(x): return own_package.model.g(x)": "own_package.model.g",
        "from own_package import model\ndef f(x): return model.g(x)": "own_package.model.g",
        "from own_package.model import g\ndef f(x): return g(x)": "own_package.model.g",
        "def f(x):\n    from own_package.model import g\n    return g(x)": "own_package.model.g",
        "def f(x):\n    import own_package.model as m\n    return m.g(x)": "own_package.model.g",
        "def f(x):\n    from own_package import model\n    return model.g(x)": "own_package.model.g",
        "from own_package import model\ndef f(x):\n    m = model\n    return m.g(x)": "own_package.model.g",
        "from own_package import model\ndef f(x): return getattr(model, 'g')(x)": "own_package.model.g",
        "def make():\n    from own_package import model\n    return lambda x: model.g(x)\nf = make()": "own_package.model.g",
        "from own_package import model\ndef f(x): return x + model.A": "own_package.model.A",
    }
    for text, changed in uses.items():
        told = []
        for number in (2.0, 3.0):
            (package / "model.py").write_text(f"A = {number}\ndef g(x): return x + {number}\n")
            for name in ("own_package", "own_package.model"):
                sys.modules.pop(name, None)
            (package / "__pycache__" / f"model.cpython-{sys.version_info[0]}{sys.version_info[1]}.pyc").unlink(missing_ok=True)
            told.append(parts(made(text)))
        assert told[0][changed] != told[1][changed], text


def test_what_cannot_be_looked_through_needs_a_key():
    import ctypes
    import threading

    pointer = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_double)(abs)
    lock = made("import threading\nlock = threading.Lock()\ndef f(x):\n    with lock: return x")
    for opaque, what in ((pointer, "CFunctionType"), (lambda x: pointer(x), "CFunctionType"), (lock, "edited_here.lock")):
        with pytest.raises(ValueError, match=rf"(?s){what}.*cannot be told from others.*key="):
            fingerprint(opaque)
        assert fingerprint(opaque, "one") == fingerprint(opaque, "one")
    with_lock = "import threading\nlock = threading.Lock()\ndef f(x):\n    with lock: return x + {}"
    # What can be looked through is, with a key too.
    assert fingerprint(made(with_lock.format(1)), "one") != fingerprint(made(with_lock.format(2)), "one")
    assert isinstance(threading.Lock(), object)


def test_libraries_are_told_by_what_was_installed():
    told = parts(made("import numpy as np, math\ndef f(x): return np.sin(x) + math.cos(x) + abs(x)"))
    assert set(told) == {"callable", "edited_here.f", "library numpy", "library python"}
