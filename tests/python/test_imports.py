"""Files import one way, and so do crates: nothing goes round in a circle."""

import re
import tomllib
from pathlib import Path

import pytest
from imports import NOISE, Crate, circle

ROOT = Path(__file__).parents[2]
MEMBERS = tomllib.loads((ROOT / "Cargo.toml").read_text(encoding="utf-8"))["workspace"]["members"]

# What each crate of the product may be built from, of ours.
ALLOWED = {
    "detector": set(),
    "designer/world": {"detector"},
    "designer/verify": set(),
    "designer/blas-src": set(),
    "designer/drives": set(),
    "designer/identification": {"drives"},
    "designer/drives/zstd": set(),
    "designer": {"detector", "verify", "world"},
    "modelDescription": set(),
    "fmu/core": {"model-description"},
    "fmu/fmi2": {"fmu-core", "model-description"},
    "fmu/fmi3": {"fmu-core", "model-description"},
    "fmu/detector": {"detector", "fmu-core", "model-description"},
    "fmu/detector/cdylib": {"fmu", "fmu-core", "fmi2"},
    "fmu/detector/cdylib-fmi3": {"fmu", "fmu-core", "fmi3"},
    "fmu/plant": {"detector", "world", "fmu-core", "model-description"},
    "fmu/plant/cdylib": {"plant", "fmu-core", "fmi2"},
    "packaging": {
        "detector", "world", "drives", "identification", "designer", "verify", "model-description", "fmu-core",
        "fmi2", "fmi3", "fmu", "plant",
    },
}  # fmt: skip


@pytest.mark.parametrize("member", [m for m in MEMBERS if (ROOT / m / "src").is_dir()])
def test_no_files_import_in_a_circle(member):
    found = circle(Crate(ROOT / member).imports())
    assert found is None, f"{member}: " + " -> ".join([*found, found[0]])


@pytest.mark.parametrize("member", [m for m in MEMBERS if not m.startswith("tests/")])
def test_crates_depend_one_way(member):
    manifest = tomllib.loads((ROOT / member / "Cargo.toml").read_text(encoding="utf-8"))
    ours = {name for name in manifest.get("dependencies", {}) if name.startswith("steerguard-")}
    beyond = {name.removeprefix("steerguard-") for name in ours} - ALLOWED[member]
    assert not beyond, f"{member} must not depend on {', '.join(sorted(beyond))}"


@pytest.fixture
def crate(tmp_path):
    """A crate from texts of its files."""

    def written(**files):
        for name, text in files.items():
            path = tmp_path / "src" / f"{name.replace('__', '/')}.rs"
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
        return Crate(tmp_path).imports()

    return written


def test_a_circle_is_found_through_a_re_export(crate):
    graph = crate(
        lib="mod a;\nmod room;\n",
        a="use crate::room::{Thing, deep::Other as _};\npub struct A;\n",
        room__mod="pub mod deep;\npub use deep::Thing;\n",
        room__deep="pub struct Thing(crate::a::A);\npub struct Other;\n",
    )
    assert graph["src/a.rs"] == {"src/room/deep.rs"}
    assert graph["src/room/mod.rs"] == set(), "it only declares and re-exports"
    assert circle(graph) == ["src/a.rs", "src/room/deep.rs"]


def test_comments_strings_and_tests_import_nothing(crate):
    graph = crate(
        lib="mod a;\nmod b;\nuse a::A;\n",
        a="//! See [`crate::b::B`].\nuse super::b::B;\npub struct A(B);\n",
        b='/* crate::a::A */ pub struct B;\nconst TEXT: &str = "crate::a::A";\n'
        "#[cfg(test)]\nmod tests {\n    use crate::a::A;\n}\n",
    )
    assert graph == {"src/lib.rs": {"src/a.rs"}, "src/a.rs": {"src/b.rs"}, "src/b.rs": set()}
    assert circle(graph) is None


@pytest.mark.parametrize("room", ["detector/src", "fmu/detector/src", "fmu/core/src"])
def test_a_sample_needs_no_function_but_the_square_root(room):
    """Without the standard library there are no others than those of libm."""
    texts = [NOISE.sub(" ", path.read_text(encoding="utf-8")) for path in (ROOT / room).rglob("*.rs")]
    assert any("#![cfg_attr" in text or "#![no_std]" in text for text in texts)
    functions = {name for text in texts for name in re.findall(r"libm::(\w+)", text)}
    assert functions <= {"sqrt"}, f"{room} calls {', '.join(sorted(functions))}"
