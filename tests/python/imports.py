"""Which files of a Rust crate import from which, read from their text.

- An import is a path that begins with `crate`, `super`, `self` or a submodule, in a `use` or in code;
  comments, strings and `#[cfg(test)]` modules are left out.
- A path leads to the file that defines its item: a re-export (`pub use`) is followed, and is no
  import by itself, so that files which only declare and re-export modules are passed through.
"""

import re
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

NOISE = re.compile(
    r'//[^\n]*|/\*.*?\*/|b?r(#*)".*?"\1|"(?:\\.|[^"\\])*"|\'(?:\\[^\']+|[^\\\'])\'', re.DOTALL
)
TESTS = re.compile(r"#\[cfg\((?:test|all\(test[^\]]*)\)\]\s*(?:pub(?:\(\w+\))? )?mod \w+ \{")
DECLARED = re.compile(r"^\s*(?:pub(?:\(\w+\))? )?mod (\w+);", re.MULTILINE)
INLINE = re.compile(r"\bmod (\w+) \{")
USE = re.compile(r"\b(pub(?:\([^)]*\))? )?use ([^;]+);")
PATH = re.compile(r"(?<![\w:$])((?:\w+::)+)(\w+|\*|\{)")


def closing(text, start):
    """Index after the brace that closes the one at `start`."""
    depth = 0
    for index in range(start, len(text)):
        depth += (text[index] == "{") - (text[index] == "}")
        if depth == 0:
            return index + 1
    return len(text)


def leaves(tree):
    """Paths of a `use` tree, each with the name it gets."""
    tree = tree.strip()
    head, brace, rest = tree.partition("{")
    if brace:
        parts, depth, part = [], 0, ""
        for character in rest[: rest.rindex("}")]:
            depth += (character == "{") - (character == "}")
            if character == "," and depth == 0:
                parts.append(part)
                part = ""
            else:
                part += character
        for part in [*parts, part]:
            if part.strip():
                yield from leaves(head + part.strip())
        return
    path, _, name = tree.partition(" as ")
    segments = path.removesuffix("::self").split("::")
    yield segments, name.strip() or segments[-1]


@dataclass
class Module:
    """A module and the file that it stands in."""

    file: Path
    parent: "Module | None"
    name: str
    children: dict = field(default_factory=dict)
    reexports: dict = field(default_factory=dict)
    globs: list = field(default_factory=list)
    paths: list = field(default_factory=list)


class Crate:
    """The modules of a crate, from its `src/lib.rs` (or `main.rs`)."""

    def __init__(self, folder):
        self.folder = Path(folder)
        source = self.folder / "src"
        top = source / "lib.rs"
        self.modules = []
        self.root = self._read(top if top.is_file() else source / "main.rs", None, "crate", source)

    def _read(self, file, parent, name, folder):
        text = NOISE.sub(lambda noise: " " * len(noise[0]), file.read_text(encoding="utf-8"))
        while test := TESTS.search(text):
            text = text[: test.start()] + text[closing(text, test.end() - 1) :]
        return self._module(text, file, parent, name, folder)

    def _module(self, text, file, parent, name, folder):
        module = Module(file, parent, name)
        self.modules.append(module)
        while inline := INLINE.search(text):
            end = closing(text, inline.end() - 1)
            body = text[inline.end() : end - 1]
            child = inline[1]
            module.children[child] = self._module(body, file, module, child, folder / child)
            text = text[: inline.start()] + text[end:]
        for child in DECLARED.findall(text):
            for path in [folder / f"{child}.rs", folder / child / "mod.rs"]:
                if path.is_file() and child != "tests":
                    module.children[child] = self._read(path, module, child, folder / child)
        imported = []
        for public, tree in USE.findall(text):
            for path, alias in leaves(tree):
                if public and path[-1] == "*":
                    module.globs.append(path[:-1])
                elif public:
                    module.reexports[alias] = path
                else:
                    imported.append(path)
        code = USE.sub(" ", text)
        # A re-export whose name the file itself uses is an import too.
        used = set(re.findall(r"\w+", code))
        imported += [path for name, path in module.reexports.items() if name in used]
        imported += [[*head.removesuffix("::").split("::"), last] for head, last in PATH.findall(code)]
        module.paths = imported
        return module

    def _start(self, module, path):
        """Where a path begins, and what follows; None outside of this crate."""
        at, rest = module, list(path)
        if rest[0] == "crate":
            return self.root, rest[1:]
        if rest[0] in module.children:
            return module, rest
        if rest[0] not in ("self", "super"):
            return None, []
        while rest and rest[0] in ("self", "super"):
            at = at.parent or at if rest.pop(0) == "super" else at
        return at, rest

    def target(self, module, path, seen=()):
        """File that defines what a path names, or None outside of this crate."""
        at, rest = self._start(module, path)
        while at is not None and rest:
            name = rest[0]
            if name in at.children:
                at, rest = at.children[name], rest[1:]
            elif name in at.reexports and (at.file, name) not in seen:
                followed = at.reexports[name] + rest[1:]
                return self.target(at, followed, (*seen, (at.file, name)))
            else:
                break
        return at and at.file

    @cache
    def imports(self):
        """Files of the crate to the files that they import from, both relative to the crate."""
        graph = {}
        for module in self.modules:
            targets = graph.setdefault(self._short(module.file), set())
            for path in module.paths:
                target = self.target(module, path)
                if target is not None and target != module.file:
                    targets.add(self._short(target))
        return graph

    def _short(self, file):
        return str(file.relative_to(self.folder))


def circle(graph):
    """A shortest circle of a graph as its nodes in order, or None."""
    shortest = None
    for start in graph:
        before, queue = {start: None}, [start]
        for node in queue:
            for following in sorted(graph.get(node, ())):
                if following == start:
                    nodes = [node]
                    while before[nodes[-1]] is not None:
                        nodes.append(before[nodes[-1]])
                    if shortest is None or len(nodes) < len(shortest):
                        shortest = nodes[::-1]
                elif following not in before:
                    before[following] = node
                    queue.append(following)
    return shortest
