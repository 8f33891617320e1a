# Sourced by ./run and ./test: installs what is missing and builds. Prints nothing when there is
# nothing to do.
set -euo pipefail

fail() {
  echo "error: $*" >&2
  exit 2
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

install_packages() {
  local missing
  mapfile -t missing < <(missing_packages "$1")
  [ ${#missing[@]} -gt 0 ] || return 0
  command -v apt-get >/dev/null ||
    fail "apt-get not found; install the equivalents of: ${missing[*]}"
  local as_root=()
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || fail "not root and no sudo; as root: apt-get install ${missing[*]}"
    as_root=(sudo)
  fi
  echo "installing ${missing[*]}"
  local log
  log=$(mktemp)
  if ! { "${as_root[@]}" apt-get update -qq &&
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq \
      --no-install-recommends "${missing[@]}"; } >"$log" 2>&1; then
    tail -n 25 "$log" >&2
    rm -f "$log"
    fail "apt-get could not install: ${missing[*]} (its last lines are above)"
  fi
  rm -f "$log"
}

# The libraries that draw the report's plots, as package-lock.json pins them.
install_plot_libraries() {
  local stamp=node_modules/.powdercal-lock
  cmp -s package-lock.json "$stamp" 2>/dev/null && return 0
  echo "installing the plot libraries (npm)"
  local log
  log=$(mktemp)
  if ! npm ci --no-audit --no-fund --ignore-scripts --loglevel=error >"$log" 2>&1; then
    tail -n 25 "$log" >&2
    rm -f "$log"
    fail "npm ci failed (its last lines are above)"
  fi
  rm -f "$log"
  cp package-lock.json "$stamp"
}

# build TARGET…
build() {
  local log status=0
  log=$(mktemp)
  if [ ! -f build/release/build.ninja ]; then
    echo "configuring"
    cmake --preset release >"$log" 2>&1 || status=$?
  fi
  if [ $status -eq 0 ] && ! ninja -C build/release -n "$@" 2>/dev/null | grep -q "no work to do"; then
    echo "building; a first build takes some minutes"
    cmake --build --preset release --target "$@" >"$log" 2>&1 || status=$?
  fi
  if [ $status -ne 0 ]; then
    tail -n 60 "$log" >&2
    rm -f "$log"
    fail "the build failed (its last lines are above)"
  fi
  rm -f "$log"
}
