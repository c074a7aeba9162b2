#!/usr/bin/env bash
# setup.sh runtime: .venv with ROS 2 Jazzy, the numerics and this package.
# setup.sh test: that, the test tools, and what `fleet` installs.
# setup.sh fleet: runtime, and what shares studies among processes and machines.
# setup.sh peers: runtime, and what benchmarks.peers compares with.
# setup.sh docs: runtime, and what `make docs` builds the pages with.
# setup.sh design: runtime, and what obs_ros.observers.papers.design solves matrix inequalities with.
# Each finished step leaves a fingerprint of what it was made from in .venv/.steps, so the next run
# does only what is missing or out of date, and needs no network when nothing is.
set -euo pipefail
cd "$(dirname "$0")/.."

# A sourced ROS, or pip settings that install elsewhere, would mix with the wheels in .venv.
unset PYTHONPATH PYTHONHOME PIP_TARGET PIP_PREFIX PIP_USER PIP_QUIET

steps=.venv/.steps
log=$steps/pip.log

say() { echo "setup: $*"; }
fail() {
  echo "setup: $*" >&2
  exit 1
}

exec 8>&2  # the terminal, wherever a step's own words go
child=
grace=50  # tenths of a second that a step gets to end by itself

# Runs a command that may take long, in a session of its own, so that Ctrl-C reaches it through
# `stopped` alone and what it says of that goes nowhere.
run() {
  setsid "$@" </dev/null &
  child=$!
  local code=0
  wait "$child" || code=$?
  child=
  return "$code"
}

stopped() {
  trap '' INT TERM
  for signal in ${child:+TERM KILL}; do
    kill -s "$signal" -- "-$child" || kill -s "$signal" "$child" || break
    for (( tenths = 0; tenths < grace; tenths++ )); do
      kill -s 0 "$child" || break 2
      sleep 0.1
    done
  done 2>/dev/null
  unless_changed
  echo 'setup: stopped; run it again to go on' >&8
  exit 130
}
trap stopped INT TERM

# A step that was cut short before it changed anything leaves .venv whole.
unless_changed() {
  grep -qs '^Installing collected packages' "$log" || rm -f "$steps/busy"
}

# Prints 'ok', or what is wrong with the interpreter $1. Old Pythons must be able to read it.
judge() {
  timeout 20 "$1" - 2>/dev/null <<'PY' || echo 'does not run'
import platform
import sys
import sysconfig

version = '.'.join(str(part) for part in sys.version_info[:3])
verdict = 'ok'
if not (3, 11) <= sys.version_info[:2] <= (3, 13) or sys.implementation.name != 'cpython':
    verdict = 'is %s %s' % (platform.python_implementation(), version)
elif 'musl' in (sysconfig.get_config_var('HOST_GNU_TYPE') or ''):
    verdict = 'is built on musl, and the ROS wheels need glibc'
else:
    try:
        import ensurepip
        import venv
    except ImportError:
        name = 'python%d.%d-venv' % sys.version_info[:2]
        verdict = 'has no venv (Debian, Ubuntu: apt install %s)' % name
print(verdict)
PY
}

# Sets $python to the interpreter that .venv is made with: $PYTHON, or the first that will do.
choose_python() {
  local candidate verdict found=''
  local -a candidates=("${PYTHON:-}")
  [[ -n ${PYTHON:-} ]] ||
    mapfile -t candidates < <(type -ap python3.12 python3.11 python3.13 python3)
  for candidate in "${candidates[@]}"; do
    verdict=$(judge "$candidate")
    if [[ $verdict == ok ]]; then
      python=$candidate
      return
    fi
    found+="${found:+; }$candidate ${verdict:-is not a Python}"
  done
  fail "needs CPython 3.11, 3.12 or 3.13 with venv, but ${found:-there is no Python here};" \
    'install one, or name it: make setup PYTHON=/path/to/python3.12'
}

fingerprint() { sha256sum "$@" | sha256sum; }
version() { "$1" -S -c 'import sys; print(sys.version)' 2>/dev/null; }

# Whether .venv is whole: made here (its scripts hold this path), no step cut short, right Python.
venv_is_sound() {
  [[ -f $steps/venv && $(<"$steps/venv") == "$PWD" && ! -e $steps/busy ]] &&
    version .venv/bin/python >/dev/null &&
    [[ -z ${PYTHON:-} || $(version "$PYTHON") == "$(version .venv/bin/python)" ]]
}

# pip_step <name> <fingerprint> <what, in words> <arguments of pip install>
pip_step() {
  local name=$1 wanted=$2 words=$3 reason
  shift 3
  [[ -f $steps/$name && $(<"$steps/$name") == "$wanted" ]] && return
  say "installing $words ..."
  : >"$log"
  touch "$steps/busy"
  if ! run .venv/bin/python -m pip install --no-input "$@" >"$log" 2>&1; then
    unless_changed
    if grep -qiE 'connection|name resolution|unreachable|timed out' "$log"; then
      fail 'no package index could be reached; set-up needs the network once: connect, run it again'
    fi
    reason=$(grep -im1 '^ *error: ' "$log" || tail -n1 "$log")
    fail "pip failed at the step '$name': ${reason#*: } (all of it in $log)"
  fi
  rm "$steps/busy"
  echo "$wanted" >"$steps/$name"
}

what=${1:-test}
[[ "$(uname -s) $(uname -m)" == 'Linux x86_64' ]] ||
  fail "needs Linux on x86-64, as the ROS wheels do; this is $(uname -s) on $(uname -m)"

# Two makes at once take turns.
exec 9<tools/setup.sh
if ! flock -n 9; then
  say 'another make is setting up .venv: waiting until it is done ...'
  run flock 9
fi

if ! venv_is_sound; then
  choose_python
  say "making .venv with $python (seconds) ..."
  run "$python" -m venv --clear .venv 2>/dev/null ||
    fail "$python could not make a virtual environment in .venv"
  mkdir "$steps"
  echo "$PWD" >"$steps/venv"
  made_anew=1
fi

pip_step runtime "$(fingerprint requirements/{pins,runtime}.txt)" \
  'ROS 2 Jazzy, NumPy, SciPy, Numba and Matplotlib (180 MB, 1-3 minutes)' \
  -r requirements/runtime.txt
if [[ $what == test ]]; then
  pip_step test "$(fingerprint requirements/{pins,runtime,test}.txt)" \
    'pytest, hypothesis, ruff and mypy (30 MB, 10-30 seconds)' -r requirements/test.txt
fi
if [[ $what == fleet || $what == test ]]; then
  pip_step fleet "$(fingerprint requirements/{pins,runtime,fleet}.txt)" \
    'Dask distributed and PyArrow (60 MB, half a minute)' -r requirements/fleet.txt
fi
if [[ $what == peers ]]; then
  pip_step peers "$(fingerprint requirements/{pins,runtime,peers}.txt)" \
    'pygmo, pymoo, pycma, CasADi, do-mpc and filterpy (120 MB, 1-2 minutes)' \
    -r requirements/peers.txt
fi
if [[ $what == design ]]; then
  pip_step design "$(fingerprint requirements/{pins,runtime,design}.txt)" \
    'CVXPY and Clarabel (90 MB, half a minute)' -r requirements/design.txt
fi
if [[ $what == docs ]]; then
  pip_step docs "$(fingerprint requirements/{pins,runtime,docs}.txt)" \
    'Sphinx and MyST (40 MB, half a minute)' -r requirements/docs.txt
fi
# Installed, not linked: an editable install has no data files, so it is not in the ament index.
# Built in .venv, since modules deleted here would live on in build/, which colcon uses as well.
mapfile -t sources < <(
  find setup.* pyproject.toml package.xml resource tools/launchers config layouts \
    obs_ros plant_sim -type f -not -name '*.pyc' | LC_ALL=C sort
)
rm -rf "$steps/build"
mkdir "$steps/build"
printf '[build]\nbuild_base=%s\n[egg_info]\negg_base=%s\n' "$steps"/build{,} >"$steps/build.cfg"
DIST_EXTRA_CONFIG=$steps/build.cfg pip_step package "$(fingerprint "${sources[@]}")" \
  'this package (seconds)' --no-deps --no-build-isolation --no-index .
[[ -z ${made_anew:-} ]] || say 'done'
