#!/usr/bin/env bash
# Instructions and work of one small frame a method against bench/record/counts.toml: prints pass or FAIL, exit code 0 or 1.
#   bench/counts.sh                     all (needs valgrind)
#   bench/counts.sh --no-instructions   work counters only
#   bench/counts.sh --update            record what is found
set -euo pipefail
cd "$(dirname "$0")"
cargo build --release --locked --quiet --package bench-counts
exec "${CARGO_TARGET_DIR:-target}/release/antumbra-counts" check --record record/counts.toml "$@"
