#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Make the virtual environment that the Makefile works in: tools/setup.sh FOLDER
#   PYTHON=...              use this interpreter; otherwise the first Python 3.11 or 3.13 found
#   LAMINA_BPY=4.5|5.0|5.1|5.2|5.3  the Blender to install; otherwise 4.5 on Python 3.11, 5.2 on Python 3.13
#   LAMINA_APT=1            install missing Debian packages (root only) instead of naming them
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
venv=${1:?usage: tools/setup.sh FOLDER}

fail() { echo "lamina: $*" >&2; exit 1; }

may_install() { [ "${LAMINA_APT:-}" = 1 ] && [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; }
install_packages() {
  echo "Installing Debian packages: $*"
  apt-get update -qq && DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "$@" >/dev/null
}

[ ! -L "$venv" ] || fail "$venv is a link to $(readlink "$venv"), which would be emptied: remove the link, or set up in the folder it leads to"

case ${LAMINA_BPY:-} in
  "") versions="3.11 3.13" ;;
  4.5 | 5.0) versions="3.11" ;;
  5.1 | 5.2 | 5.3) versions="3.13" ;;
  *) fail "LAMINA_BPY is '$LAMINA_BPY'; choose 4.5, 5.0, 5.1, 5.2 or 5.3" ;;
esac

# True if $1 is a Python of version $2 that can make virtual environments. It is run, because pyenv's shims exist
# for versions that are not selected.
usable() {
  "$1" -c 'import sys, venv, ensurepip; sys.exit("%d.%d" % sys.version_info[:2] != sys.argv[1])' "$2" 2>/dev/null
}

find_python() {
  local version candidate
  for version in $versions; do
    for candidate in ${PYTHON:-"python$version" python3 "${PYENV_ROOT:-$HOME/.pyenv}/versions/$version".*/bin/python}; do
      if usable "$candidate" "$version"; then echo "$candidate $version"; return; fi
    done
  done
  return 1
}

if ! found=$(find_python); then
  [ -z "${PYTHON:-}" ] || fail "PYTHON=$PYTHON is not a Python ${versions// / or } with the venv module, which Blender's bpy needs"
  if may_install; then
    for version in $versions; do
      ! install_packages "python$version-venv" 2>/dev/null || break
    done
  fi
  hint=
  [[ $versions != *3.11* ]] || hint+=" Debian 12: apt-get install python3.11-venv."
  [[ $versions != *3.13* ]] || hint+=" Debian 13: apt-get install python3.13-venv."
  found=$(find_python) || fail "Blender's bpy needs Python ${versions// / or } with venv.$hint" \
    "Elsewhere: pyenv install ${versions%% *}, or make PYTHON=/path/to/python"
fi
read -r python version <<<"$found"

case ${LAMINA_BPY:-}/$version in
  5.0/*) requirements=requirements/py311-bpy50.txt ;;
  5.1/*) requirements=requirements/py313-bpy51.txt ;;
  5.3/*) requirements=requirements/py313-bpy53.txt ;;
  */3.11) requirements=requirements/py311-bpy45.txt ;;
  */3.13) requirements=requirements/py313-bpy52.txt ;;
esac

echo "Setting up $venv: Python $version, $requirements (the first time downloads about 400 MB)"
"$python" -m venv --clear "$venv"
pip() { "$venv/bin/python" -m pip --disable-pip-version-check "$@"; }
pip install --require-hashes --only-binary :all: -r "$requirements" ||
  fail "pip could not install $requirements (its message is above)"
pip install --quiet --no-build-isolation --no-deps --editable . || fail "pip could not install lamina itself (see above)"

if may_install; then
  packages=$("$venv/bin/python" tools/check_bpy.py --packages)
  # shellcheck disable=SC2086  # a list of names
  [ -z "$packages" ] || install_packages $packages || fail "apt-get could not install $packages"
fi
"$venv/bin/python" tools/check_bpy.py || exit 1
