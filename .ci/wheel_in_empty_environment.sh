#!/usr/bin/env bash
# Build the wheel, install it into an empty environment and use it there, away from the source tree.
#
#   .ci/wheel_in_empty_environment.sh [DIR]    DIR keeps everything; a temporary folder otherwise
set -euo pipefail
cd "$(dirname "$0")/.."
python=${PYTHON:-.venv/bin/python}
if [ $# -gt 0 ]; then mkdir -p "$1"; work=$(cd "$1" && pwd)
else work=$(mktemp -d); trap 'rm -rf "$work"' EXIT; fi
unset PYTHONPATH

"$python" -m pip --disable-pip-version-check --quiet wheel --no-deps --no-build-isolation --wheel-dir "$work/dist" .
wheel=$(ls "$work"/dist/rig2sea-*.whl)
if [ ! -x "$work/env/bin/rig2sea" ]; then
    "$python" -m uv venv --quiet "$work/env"
    # the versions of the lock, and only what the wheel asks for
    grep -oE '^[A-Za-z0-9_.-]+==[^ ]+' requirements.lock >"$work/versions.txt"
    "$python" -m uv pip install --quiet --python "$work/env/bin/python" --constraint "$work/versions.txt" "$wheel"
else
    "$python" -m uv pip install --quiet --python "$work/env/bin/python" --no-deps --reinstall "$wheel"
fi

rm -rf "$work/use"
mkdir "$work/use"
cd "$work/use"
rig2sea=$work/env/bin/rig2sea
say() { printf '\n== rig2sea %s\n' "$*"; "$rig2sea" "$@"; }

"$work/env/bin/python" -c 'import pipeline, sys; print(pipeline.__file__); sys.exit("site-packages" not in pipeline.__file__)'
say new mmt300 --example
rm -r raw/mmt300/pool          # runs are long; the bench is enough here
say check mmt300 >check.txt || { cat check.txt; exit 1; }
say run mmt300
say run mmt300 | tee again.txt
grep -q 'Nothing to do' again.txt
say export mmt300 --to firmware
test -s firmware/mmt300_thruster.h
test -s reports/index.html
say new myauv >/dev/null
say check myauv >/dev/null
say effects mmt300 >/dev/null
say simulate mmt300 --manoeuvre straight --duration 5 --effect current:north_mps=0.2 --to flown.mcap
test -s flown.mcap
"$rig2sea" design balance --example >balance.yaml
say design balance balance.yaml
printf '\nThe wheel works without the source tree.\n'
