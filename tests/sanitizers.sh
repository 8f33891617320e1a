#!/usr/bin/env bash
# tests/sanitizers.sh sanitize|thread: builds the engine's tests with AddressSanitizer and
# UndefinedBehaviorSanitizer, or with ThreadSanitizer, and runs them.
set -euo pipefail
cd "$(dirname "$0")/.."
preset=$1
if [ "$preset" = thread ]; then
  tests=(physics_slow_tests --gtest_filter='Determinism.*DoesNotDependOnThreads')
else
  tests=(physics_tests)
fi
cmake --preset "$preset" > /dev/null
cmake --build --preset "$preset" --target "${tests[0]}"
"build/$preset/tests/physics/${tests[0]}" --gtest_brief=1 "${tests[@]:1}"
