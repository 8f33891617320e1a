# Sourced by ./run and ./test: installs what is missing and builds. Prints nothing when there is
# nothing to do.
set -euo pipefail

fail() {
  echo "error: $*" >&2
  exit 2
}

# quietly LINES MESSAGE COMMAND…: runs COMMAND; where it fails, shows its last LINES lines and MESSAGE.
quietly() {
  local lines=$1 message=$2
  shift 2
  log=$(mktemp)
  trap 'rm -f "$log"' EXIT
  if ! "$@" >"$log" 2>&1 </dev/null; then
    tail -n "$lines" "$log" >&2
    fail "$message (its last lines are above)"
  fi
  rm -f "$log"
}

writable() {
  [ -w . ] || fail "$PWD is not writable for $(id -un); run this in a copy of your own"
}

# missing_packages KIND: packages of packages.txt that are not there; KIND is run or test.
missing_packages() {
  local line package command
  while IFS= read -r line; do
    line=${line%%#*}
    read -r package command <<<"$line" || true
    [ -n "${package:-}" ] || continue
    if [[ $package == test:* ]]; then
      [ "$1" = test ] || continue
      package=${package#test:}
    fi
    if [ -n "${command:-}" ] && command -v "$command" >/dev/null 2>&1; then continue; fi
    if [ "$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null)" != installed ]; then
      echo "$package"
    fi
  done <packages.txt
}

# apt_get PACKAGE…; install_packages sets as_root.
apt_get() {
  "${as_root[@]}" apt-get update -qq &&
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq \
      --no-install-recommends -o DPkg::Lock::Timeout=300 "$@"
}

install_packages() {
  local missing
  mapfile -t missing < <(missing_packages "$1")
  [ ${#missing[@]} -gt 0 ] || return 0
  command -v apt-get >/dev/null ||
    fail "apt-get not found; install the equivalents of: ${missing[*]}"
  local as_root=()
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null ||
      fail "packages are missing, and this is not root and has no sudo; as root:" \
        "apt-get update && apt-get install --no-install-recommends ${missing[*]}"
    as_root=(sudo)
  fi
  echo "installing ${missing[*]}"
  quietly 40 "apt-get could not install the missing packages" apt_get "${missing[@]}"
}

# The libraries that draw the report's plots, as package-lock.json pins them.
install_plot_libraries() {
  local stamp=node_modules/.powdercal-lock
  cmp -s package-lock.json "$stamp" 2>/dev/null && return 0
  writable
  echo "installing the plot libraries (npm)"
  quietly 25 "npm ci failed" \
    npm ci --no-audit --no-fund --ignore-scripts --loglevel=error
  cp package-lock.json "$stamp"
}

# Ninja sees every later change but those of the presets, and a tree that was moved or copied.
configured() {
  [ build/release/build.ninja -nt CMakePresets.json ] &&
    [ "$(sed -n 's/^CMAKE_HOME_DIRECTORY:INTERNAL=//p' build/release/CMakeCache.txt)" -ef . ]
}

# build TARGET…
build() {
  if ! configured 2>/dev/null; then
    writable
    echo "configuring"
    quietly 60 "CMake could not configure" cmake --fresh --preset release
  fi
  if ! ninja -C build/release -n "$@" 2>/dev/null | grep -q "no work to do"; then
    writable
    echo "building; a first build takes some minutes"
    quietly 60 "the build failed" cmake --build --preset release --target "$@"
  fi
}
