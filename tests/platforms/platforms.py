"""Drives the packaged reference input through the library of every platform, and shows what each library is.

For each FMU and platform that runs here, in itself or emulated, all outputs and local variables are compared bit
for bit with those of linux64, and the outputs with the packaged reference results. macOS is inspected only.
"""

import argparse
import hashlib
import os
import re
import shutil
import struct
import subprocess
import sys
import zipfile
from pathlib import Path

import fmpy
import numpy as np

FMUS = {"SteeringFaultDetector": "detector", "VehiclePlant": "plant"}
EXTENSIONS = {"linux64": "so", "aarch64-linux": "so", "win64": "dll", "darwin64": "dylib"}
KINDS = ("Real", "Integer", "Boolean")
FUNCTIONS = 44  # of FMI 2.0
FUNCTIONS_OF_3 = 75
COLUMNS = ["platform", "built by", "bytes", "exports", "imports", "floor", "run by",
           "values compared, all bits equal"]  # fmt: skip


def text(*command):
    return subprocess.run([str(c) for c in command], check=True, stdout=subprocess.PIPE, text=True).stdout


def version(*command):
    """The first version number that a command prints."""
    return re.search(r"[ -](\d+(\.\d+)*)", text(*command, "--version"))[1]


class Platform:
    """How libraries of a platform are built, run and read."""

    def __init__(self, name, work):
        self.name = name
        rust = f"rustc {version('/usr/bin/rustc')}"
        loader = work / "loader"
        match name:
            case "linux64":
                self.built_by = f"{rust}, gcc {version('gcc')}"
                self.compiler, self.runner, self.run_by = "gcc", [loader], "this machine"
            case "aarch64-linux":
                self.compiler = "aarch64-linux-gnu-gcc"
                self.built_by = f"{rust}, gcc {version(self.compiler)}"
                self.runner = ["qemu-aarch64", "-L", "/usr/aarch64-linux-gnu", f"{loader}-arm"]
                self.run_by = f"qemu {version('qemu-aarch64')}"
            case "win64":
                self.compiler = "x86_64-w64-mingw32-gcc-win32"
                self.built_by = f"{rust}, mingw gcc {version(self.compiler)}"
                self.runner = ["/usr/lib/wine/wine64", f"{loader}.exe"]
                self.run_by = f"wine {version('/usr/lib/wine/wine64')}"
            case "darwin64":
                self.built_by = f"{rust}, lld {version('ld64.lld-14')}"
                self.compiler, self.runner, self.run_by = None, None, "not run"
        if self.compiler:
            source = Path(__file__).with_name("loader.c")
            libraries = [] if name == "win64" else ["-ldl"]
            text(self.compiler, "-O1", "-Wall", "-Wextra", "-Werror", "-o", self.runner[-1], source, *libraries)

    def facts(self, library):
        """Exported and imported symbols, and the oldest system that has them."""
        match self.name:
            case "linux64" | "aarch64-linux":
                exports = text("llvm-nm-14", "-DjU", library).split()
                imports = re.findall(r"(\w+)@+(\S+)", text("readelf", "-W", "--dyn-syms", library))
                needed = re.findall(r"NEEDED.*\[(.*)\]", text("readelf", "-Wd", library))
                versions = [v.removeprefix("GLIBC_") for _, v in imports]
                floor = "glibc " + max(versions, key=lambda v: [int(part) for part in v.split(".")])
                return exports, {" ".join(needed): [name for name, _ in imports]}, floor
            case "win64":
                dump = text("x86_64-w64-mingw32-objdump", "-p", library)
                exports = re.findall(r"^\t\[ *\d+\] (\w+)$", dump, re.MULTILINE)
                imports = {}
                for table in dump.split("DLL Name: ")[1:]:
                    dll, *lines = table.splitlines()
                    rows = [re.fullmatch(r"\t[0-9a-f]+\t *\d+  (\w+)", line) for line in lines]
                    imports[dll] = [row[1] for row in rows if row]
                major, minor = (re.search(rf"{n}SubsystemVersion\t(\d+)", dump)[1] for n in ("Major", "Minor"))
                assert re.search(r"^Time/Date\t+Thu Jan  1 00:00:00 1970", dump, re.MULTILINE), "time stamp"
                return exports, imports, f"Windows {major}.{minor}"
            case "darwin64":
                facts = [self.slice_facts(library, processor) for processor in ("x86_64", "arm64")]
                imports = {k: sorted({s for f in facts for s in f[1][k]}) for k in facts[0][1]}
                assert facts[0][0] == facts[1][0] and facts[0][2] == facts[1][2], "slices differ"
                return facts[0][0], imports, facts[0][2]

    @staticmethod
    def slice_facts(library, processor):
        """The same of one processor's part of a library of macOS."""
        objdump = ["llvm-objdump-14", "--macho", f"--arch={processor}"]
        dump = text(*objdump, "--exports-trie", library)
        exports = re.findall(r"^0x[0-9A-F]+ +_(\w+)", dump, re.MULTILINE)
        imports = text("llvm-nm-14", "-ju", f"--arch={processor}", library).split()
        name = text(*objdump, "--dylib-id", library).split()[-1]
        assert name == f"@rpath/{library.name}", f"install name {name}"
        needed = re.findall(r"^\t(\S+) \(", text(*objdump, "--dylibs-used", library), re.MULTILINE)
        needed.remove(name)
        floor = re.search(r"minos (\S+)", text(*objdump, "--private-headers", library))[1]
        return exports, {" ".join(needed): [i for i in imports if i.startswith(("_", "dyld"))]}, f"macOS {floor}"


def stale_pages(library):
    """(pages, stale) of the signatures in a library of macOS, read without any code of the product."""
    data = library.read_bytes()
    assert data[:4] == b"\xca\xfe\xba\xbe", "one file for both processors"
    pages = stale = 0
    (count,) = struct.unpack_from(">I", data, 4)
    for index in range(count):
        processor, _, offset, size, _ = struct.unpack_from(">5I", data, 8 + 20 * index)
        image = data[offset : offset + size]
        (commands,) = struct.unpack_from("<I", image, 16)
        at, signature = 32, None
        for _ in range(commands):
            command, length, start = struct.unpack_from("<3I", image, at)
            signature = start if command == 0x1D else signature
            at += length
        assert signature or processor != 0x0100000C, "code for Arm is not signed"
        if not signature:
            continue
        (offset_of_directory,) = struct.unpack_from(">I", image, signature + 16)
        directory = image[signature + offset_of_directory :]
        hashes, _, _, slots, end = struct.unpack_from(">5I", directory, 16)
        page = 1 << directory[39]
        assert directory[36:38] == b"\x20\x02" and slots == -(-end // page), "SHA-256 of every page"
        for slot in range(slots):
            digest = hashlib.sha256(image[slot * page : min(end, (slot + 1) * page)]).digest()
            stale += directory[hashes + 32 * slot :][:32] != digest
        pages += slots
    return pages, stale


def kind_of(variable):
    return "Integer" if variable.type == "Enumeration" else variable.type


def read_table(folder, name):
    return np.genfromtxt(folder / "extra" / name, delimiter=",", names=True, deletechars="")


class Drive:
    """The packaged reference drive of an FMU, as a job of the loader."""

    def __init__(self, folder, job):
        self.description = fmpy.read_model_description(str(folder))
        identifier = self.description.coSimulation.modelIdentifier
        inputs, self.expected = (read_table(folder, f"{identifier}_{end}.csv") for end in ("in", "ref"))
        variables = {v.name: v for v in self.description.modelVariables}
        self.inputs = self.sorted(variables[n] for n in inputs.dtype.names[1:])
        self.outputs = self.sorted(
            v for v in variables.values() if v.causality in ("output", "local") and v.type != "String"
        )
        self.job = job
        step = float(self.description.defaultExperiment.stepSize)
        rows = len(inputs) - 1
        counts = [sum(kind_of(v) == kind for v in vs) for vs in (self.inputs, self.outputs) for kind in KINDS]
        columns = [np.arange(rows) * step, *(inputs[v.name][:-1] for v in self.inputs)]
        references = [v.valueReference for v in (*self.inputs, *self.outputs)]
        job.write_bytes(
            struct.pack("<64sd8I", self.description.guid.encode(), step, *counts, rows, 0)
            + struct.pack(f"<{len(references)}I", *references)
            + np.column_stack(columns).astype("<f8").tobytes()
        )

    @staticmethod
    def sorted(variables):
        return sorted(variables, key=lambda v: KINDS.index(kind_of(v)))

    def run(self, runner, library):
        result = self.job.with_suffix(f".{library.parent.name}.bin")
        subprocess.run([*runner, library, self.job, result], check=True, timeout=600)
        record = np.fromfile(result, "<f8").reshape(-1, len(self.outputs))
        assert len(record) == len(self.expected), f"{len(record)} rows"
        return record

    def is_expected(self, record):
        """Whether the outputs are the packaged reference results."""
        columns = {v.name: column for v, column in zip(self.outputs, record.T, strict=True)}
        names = self.expected.dtype.names[1:]
        return all(columns[n].tobytes() == self.expected[n].tobytes() for n in names)


def of_fmi3(platform, runtimes, work, extension):
    """What is wrong with the library of FMI 3.0, which is inspected alone: its results are compared on this machine, by
    tests/python/test_fmi3.py."""
    library = work / "fmi3" / platform.name / f"SteeringFaultDetector.{extension}"
    library.parent.mkdir(parents=True)
    shutil.copy(runtimes / platform.name / f"SteeringFaultDetectorFmi3.{extension}", library)
    exports, imports, floor = platform.facts(library)
    listed = "; ".join(f"{k}: {len(v)}" for k, v in imports.items())
    print(f"{platform.name}: FMI 3.0: {library.stat().st_size} bytes, {len(exports)} exports, {listed}, {floor}")
    is_fmi = len(exports) == FUNCTIONS_OF_3 and all(e.startswith("fmi3") for e in exports)
    return [] if is_fmi else [f"{platform.name}: the library of FMI 3.0 exports {sorted(exports)}"]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, help="with both FMUs, for all platforms")
    folder = parser.parse_args().folder
    work = folder / "work"
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir()
    os.environ |= {"WINEPREFIX": str(folder / "wine"), "WINEDEBUG": "-all", "WINEDLLOVERRIDES": "mscoree,mshtml="}

    drives = {}
    for fmu in FMUS:
        with zipfile.ZipFile(folder / f"{fmu}.fmu") as archive:
            archive.extractall(work / fmu)
        drives[fmu] = Drive(work / fmu, work / f"{fmu}.job")
        found = {path.name for path in (work / fmu / "binaries").iterdir()}
        assert found == set(EXTENSIONS), f"{fmu} has {sorted(found)}"

    rows, failures, own = [], [], {}
    for name, extension in EXTENSIONS.items():
        platform = Platform(name, work)
        sizes, equal, remarks = [], [], set()
        for fmu, drive in drives.items():
            library = work / fmu / "binaries" / name / f"{fmu}.{extension}"
            sizes.append(f"{library.stat().st_size} ({FMUS[fmu]})")
            exports, imports, floor = platform.facts(library)
            is_fmi = len(exports) == FUNCTIONS and all(e.startswith("fmi2") for e in exports)
            if not is_fmi:
                failures.append(f"{name}: {fmu} exports {sorted(exports)}")
            listed = "; ".join(f"{k}: {len(v)}" for k, v in imports.items())
            if fmu == "SteeringFaultDetector":
                print(f"{name}: {fmu} imports", "; ".join(f"{k}: {' '.join(v)}" for k, v in imports.items()))
            remarks.add((f"{len(exports)} fmi2" if is_fmi else "NOT FMI ALONE", listed, floor))
            if name == "darwin64":
                pages, stale = stale_pages(library)
                print(f"{name}: {fmu}: {pages} page hashes, {stale} stale")
                if stale or not pages:
                    failures.append(f"{name}: {fmu}: {stale} of {pages} page hashes are stale")
            if platform.runner:
                record = drive.run(platform.runner, library)
                first = own.setdefault(fmu, record)
                same = record.tobytes() == first.tobytes() and drive.is_expected(record)
                equal.append(f"{record.size if same else 'NO'} ({FMUS[fmu]})")
                if not same:
                    failures.append(f"{name}: {fmu} gives other bits")
        exports, listed, floors = (" / ".join(sorted(set(column))) for column in zip(*remarks, strict=True))
        rows.append([name, platform.built_by, ", ".join(sizes), exports, listed, floors, platform.run_by,
                     ", ".join(equal) or "-"])  # fmt: skip
        failures += of_fmi3(platform, folder / "runtimes", work, extension)
    for row in [COLUMNS, ["-" * len(c) for c in COLUMNS], *rows]:
        print("|", " | ".join(row), "|")
    print(*failures, sep="\n")
    return bool(failures)


if __name__ == "__main__":
    sys.exit(main())
