# Sourced by tests/run and .ci/run from the project's root: the Python environment of the tests, from
# the hash-locked requirements, and what the importer package needs to build.
#
# Sets CARGO_TARGET_DIR (absolute), tests_folder, python, LIBCLANG_PATH, BINDGEN_EXTRA_CLANG_ARGS.
# shellcheck shell=bash

mkdir -p "${CARGO_TARGET_DIR:-target}"
CARGO_TARGET_DIR=$(cd "${CARGO_TARGET_DIR:-target}" && pwd)
export CARGO_TARGET_DIR
tests_folder=$CARGO_TARGET_DIR/tests
python=$tests_folder/venv/bin/python

# need COMMAND WHAT: ends the run if COMMAND fails.
need() {
    if ! eval "$1" >/dev/null 2>&1; then
        printf 'tests: missing: %s\n' "$2" >&2
        exit 1
    fi
}

# Environment from tests/python/requirements.txt; kept as long as that file stays the same.
python_environment() {
    local requirements=tests/python/requirements.txt
    local stamp=$tests_folder/venv/requirements.txt
    if cmp -s "$requirements" "$stamp" && "$python" -c 'import fmpy' 2>/dev/null; then
        return
    fi
    rm -rf "$tests_folder/venv"
    python3 -m venv "$tests_folder/venv"
    if command -v uv >/dev/null; then
        uv pip install --quiet --python "$python" --require-hashes -r "$requirements"
    else
        "$python" -m pip install --quiet --disable-pip-version-check --require-hashes \
            -r "$requirements"
    fi
    cp "$requirements" "$stamp"
}

need 'command -v cargo' 'the Rust toolchain (cargo)'
need 'command -v cc' 'a C compiler and linker (Debian: apt-get install gcc libc6-dev)'
need 'python3 -c "import sys; assert sys.version_info >= (3, 11)"' \
    'Python 3.11 or newer (Debian: apt-get install python3)'
need 'python3 -c "import venv, ensurepip"' 'venv for Python (Debian: apt-get install python3-venv)'
mkdir -p "$tests_folder"
python_environment

# bindgen reads the standard's headers with libclang, which knows no compiler's include folder.
if [ -z "${LIBCLANG_PATH:-}" ]; then
    LIBCLANG_PATH=$("$python" -c 'import clang, os; print(os.path.join(clang.__path__[0], "native"))')
    BINDGEN_EXTRA_CLANG_ARGS="-I$(cc -print-file-name=include)"
    export LIBCLANG_PATH BINDGEN_EXTRA_CLANG_ARGS
fi
